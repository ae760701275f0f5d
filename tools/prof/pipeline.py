"""Cycles of a block of instructions in a core's pipeline, by llvm-mca's static model.

The choice: a block is taken as if it ran many times in a row, and its cycles are the mean of those
runs. For the body of a loop that is what happens. For straight-line code it lets a block overlap
with its neighbours as it would with itself, which is closer to a core that executes out of order
than the latency of a lone block, and it charges every dependence from one run to the next, real or
not. What the model does not know at all: caches (cache_model.h adds them), branches that were
predicted wrongly, and stores that a later load reads.
"""

import concurrent.futures
import json
import os
import re
import shutil
import subprocess

ITERATIONS = 30
PAGE = 4096  # where QEMU ends a block in any case
BRANCH_GROUP = 5  # bits 28..26: branches, exceptions, system
BLOCKS_A_RUN = 400
FEATURES = "+crc,+crypto,+neon"
CYCLES_UNKNOWN_PER_INSTRUCTION = 1.0


def tool(name):
    """Debian's plain name or the one with the version that the model was checked with."""
    for candidate in (name, name + "-14"):
        if shutil.which(candidate):
            return candidate
    raise FileNotFoundError(f"{name} is missing: make setup installs it")


def disassemble(words):
    """One line of assembly per 32-bit instruction word; None where it is no instruction."""
    text = "\n".join(
        " ".join(f"0x{word >> shift & 255:02x}" for shift in (0, 8, 16, 24)) for word in words
    )
    run = subprocess.run(
        [tool("llvm-mc"), "-triple=aarch64", "-mattr=" + FEATURES, "-disassemble"],
        input=text,
        capture_output=True,
        text=True,
        check=False,
    )
    bad = {int(line) for line in re.findall(r"<stdin>:(\d+):\d+: warning: invalid", run.stderr)}
    good = iter(
        line.strip()
        for line in run.stdout.splitlines()
        if line.startswith("\t") and not line.startswith("\t.text")
    )
    return [None if i + 1 in bad else next(good) for i in range(len(words))]


def assembly(blocks):
    """llvm-mca's input: one region per block, named by its index. Branches lose their target, since
    it is a place in another block; what a branch costs does not depend on it."""
    lines = []
    for i, block in blocks:
        lines.append(f"# LLVM-MCA-BEGIN {i}")
        lines += ["\t" + line for line in block if line is not None]
        lines.append(f"# LLVM-MCA-END {i}")
    return "\n".join(lines) + "\n"


def _analyse(core, blocks):
    """Leaves out the instructions that the model does not know, one kind after the other."""
    while True:
        run = subprocess.run(
            [
                tool("llvm-mca"),
                "-mtriple=aarch64",
                "-mattr=" + FEATURES,
                "-mcpu=" + core,
                f"-iterations={ITERATIONS}",
                "-json",
                "-all-views=false",
                "-summary-view",
            ],
            input=assembly(blocks),
            capture_output=True,
            text=True,
            check=False,
        )
        if run.returncode == 0:
            return parse(run.stdout)
        unknown = re.search(
            r"unsupported instruction.*note: instruction:\s+(\S+)", run.stderr, re.S
        )
        if not unknown:
            raise RuntimeError(f"llvm-mca: {run.stderr.strip()[:500]}")
        mnemonic = unknown.group(1)
        blocks = [
            (i, [x for x in lines if x is not None and x.split()[0] != mnemonic])
            for i, lines in blocks
        ]
        blocks = [(i, lines) for i, lines in blocks if lines]


def parse(text):
    """{index: (cycles, fewest cycles that its execution units allow)} from llvm-mca's JSON."""
    out = {}
    for region in json.loads(text)["CodeRegions"]:
        summary = region["SummaryView"]
        out[int(region["Name"])] = (
            summary["TotalCycles"] / summary["Iterations"],
            summary["BlockRThroughput"],
        )
    return out


def cached_cycles(core, blocks, folder):
    """The same as cycles(), asking llvm-mca only for blocks that no earlier run in folder had."""
    path = os.path.join(folder, f"pipeline_{core}.json")
    known = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            known = json.load(file)
    keys = ["".join(f"{word:08x}" for word in block) for block in blocks]
    new = {key: block for key, block in zip(keys, blocks) if key not in known}
    if new:
        known.update(zip(new, cycles(core, list(new.values()))))
        with open(path, "w", encoding="utf-8") as file:
            json.dump(known, file)
    return [tuple(known[key]) for key in keys]


def placed_cycles(core, blocks, folder):
    """The same for (address, words): where a page's border alone cut a block, its first part costs
    what whole and second part differ by. Otherwise linking anew would change a loop's cycles."""
    at = {address: i for i, (address, _) in enumerate(blocks)}
    cut = []
    for i, (address, words) in enumerate(blocks):
        end = address + 4 * len(words)
        if end % PAGE == 0 and end in at and words[-1] >> 26 & 7 != BRANCH_GROUP:
            cut.append((i, at[end]))
    wholes = [tuple(blocks[i][1]) + tuple(blocks[j][1]) for i, j in cut]
    found = cached_cycles(core, [words for _, words in blocks] + wholes, folder)
    out = found[: len(blocks)]
    for (i, j), whole in zip(cut, found[len(blocks) :]):
        out[i] = tuple(max(all_of - part, 0.0) for all_of, part in zip(whole, found[j]))
    return out


def cycles(core, blocks):
    """(cycles, bound) for each block, a tuple of instruction words."""
    flat = disassemble([word for block in blocks for word in block])
    at, work = 0, []
    for i, block in enumerate(blocks):
        lines = flat[at : at + len(block)]
        at += len(block)
        if any(line is not None for line in lines):
            work.append((i, lines))
    chunks = [work[i : i + BLOCKS_A_RUN] for i in range(0, len(work), BLOCKS_A_RUN)]
    found = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for part in pool.map(lambda chunk: _analyse(core, chunk), chunks):
            found.update(part)
    unknown = [len(block) * CYCLES_UNKNOWN_PER_INSTRUCTION for block in blocks]
    return [found.get(i, (unknown[i], unknown[i])) for i in range(len(blocks))]
