"""Modules of the kernel that tools/device/fetch_kernel has fetched, without their symbols."""
import shutil
import subprocess
import tempfile
from pathlib import Path


def names(path):
    """Those that a list names, one a line; what follows a # is a comment."""
    lines = (line.split("#")[0].strip() for line in Path(path).read_text().splitlines())
    return [line for line in lines if line]


def tree(kernel, wanted):
    """{path: content} of the wanted modules, those they need, and the tables of depmod."""
    release = (kernel / "release").read_text().strip()
    root = (kernel / "root").resolve()
    listed = subprocess.run(
        ["/sbin/modprobe", "-d", root, "-S", release, "-a", "--show-depends", *wanted],
        check=True, capture_output=True, text=True).stdout
    sources = sorted({line.split()[1] for line in listed.splitlines()
                      if line.startswith("insmod")})
    with tempfile.TemporaryDirectory() as folder:
        for source in sources:
            target = Path(folder) / Path(source).relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            subprocess.run(["aarch64-linux-gnu-strip", "--strip-debug", source, "-o", target],
                           check=True)
        modules = Path("lib/modules") / release
        for name in ("modules.order", "modules.builtin", "modules.builtin.modinfo"):
            shutil.copy(root / modules / name, Path(folder) / modules / name)
        subprocess.run(["/sbin/depmod", "-b", folder, release], check=True)
        return {str(path.relative_to(folder)): path.read_bytes()
                for path in sorted(Path(folder).rglob("*")) if path.is_file()}
