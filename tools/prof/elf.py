"""What the profiler needs of a program file: its functions and the names of its trace places."""

import bisect
import re
import shutil
import struct
import subprocess

TOOLS = ("aarch64-linux-gnu-nm", "nm")


class Program:
    def __init__(self, path):
        self.path = path
        with open(path, "rb") as file:
            self._data = file.read()
        self._segments = _load_segments(self._data)
        self._symbols = _functions(path)
        self._starts = [address for address, _, _ in self._symbols]

    def address_of(self, mangled):
        """Address of a function by its mangled name, 0 if there is none."""
        for address, name, _ in self._symbols:
            if name == mangled:
                return address
        return 0

    def function_at(self, address):
        """Readable name of the function that holds an address."""
        at = bisect.bisect_right(self._starts, address) - 1
        return self._symbols[at][2] if at >= 0 else f"{address:#x}"

    def place_name(self, place):
        """The name of a TracePlace: a pointer to it lies 8 bytes behind its mark."""
        if place == 0:
            return ""
        pointer = self._read(place + 8, 8)
        if pointer is None:
            return f"{place:#x}"
        at = self._offset(struct.unpack("<Q", pointer)[0])
        return (
            self._data[at : self._data.index(0, at)].decode() if at is not None else f"{place:#x}"
        )

    def _offset(self, address):
        for start, offset, size in self._segments:
            if start <= address < start + size:
                return offset + address - start
        return None

    def _read(self, address, size):
        at = self._offset(address)
        return None if at is None else self._data[at : at + size]


def _load_segments(data):
    if data[:6] != b"\x7fELF\x02\x01":
        raise ValueError("not a 64-bit little-endian ELF file")
    (offset,) = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    out = []
    for i in range(count):
        kind, _, at, address, _, bytes_in_file = struct.unpack_from(
            "<IIQQQQ", data, offset + i * size
        )
        if kind == 1:  # PT_LOAD
            out.append((address, at, bytes_in_file))
    return out


def readable(name):
    """A demangled name without namespaces' noise and arguments."""
    name = name.replace("(anonymous namespace)::", "").replace("pirvs::", "")
    depth, out = 0, []
    for c in name:  # drop template arguments
        depth += c == "<"
        if depth == 0:
            out.append(c)
        depth -= c == ">" and depth > 0
    name = "".join(out)
    name = re.sub(r"\[clone .*\]", "", name)
    return re.sub(r"\(.*", "", name).split(" ")[-1].strip() or name


def _functions(path):
    nm = next(tool for tool in TOOLS if shutil.which(tool))
    mangled = subprocess.run(
        [nm, "--defined-only", path], capture_output=True, text=True, check=True
    )
    demangled = subprocess.run(
        [nm, "--defined-only", "-C", path], capture_output=True, text=True, check=True
    )
    out = {}
    for plain, pretty in zip(mangled.stdout.splitlines(), demangled.stdout.splitlines()):
        address, kind, name = plain.split(" ", 2)
        if kind not in "tTwW" or name.startswith("$"):
            continue
        out[int(address, 16)] = (int(address, 16), name, readable(pretty.split(" ", 2)[2]))
    return [out[address] for address in sorted(out)]
