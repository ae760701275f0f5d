"""Names and bugs, by clang-tidy with the repository's .clang-tidy.

A file is read again only when it, a header of ours that it reaches, or the configuration changed:
the verdict is kept under BUILD/check/tidy by the hash of all of these.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
from pathlib import Path

FLAGS = ["-std=c++17", "-Wno-everything", "-I.", "-iquoteboard/host", "-isystem/usr/include/eigen3",
         "-isystem/usr/include/opencv4", "-DEIGEN_DONT_VECTORIZE",
         "-DEIGEN_STACK_ALLOCATION_LIMIT=18446744073709551615ul", "-DEIGEN_NO_IO"]
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
WARNING = re.compile(r"^(.*?):(\d+):\d+: (?:warning|error): (.*)$")
# Sources that only AArch64 without an operating system compiles, and how the others are.
BARE = ("bsp/bare/", "board/bare/", "board/qemu-virt/", "board/rk3399-bare/")
BARE_FLAGS = ["--target=aarch64-linux-gnu", "-mcpu=cortex-a72"]
HOST_FLAGS = ["-march=native"]
IDL_FLAGS = ["-isystembuild/idl"]  # what make leaves there of tools/ros2
AARCH64 = "a function BadName for AArch64"  # of the self-test


def reached(path, tree, seen=None):
    """`path` and every header of ours behind it."""
    seen = set() if seen is None else seen
    if path in tree and path not in seen:
        seen.add(path)
        for header in INCLUDE.findall(tree[path]):
            reached(header, tree, seen)
    return seen


def flags_of(path):
    idl = IDL_FLAGS if path.startswith("tools/ros2/") else []
    return FLAGS + (BARE_FLAGS if path.startswith(BARE) else HOST_FLAGS) + idl


def verdict_name(path, tree):
    digest = hashlib.sha256(path.encode() + " ".join(flags_of(path)).encode())
    for name in [".clang-tidy", "tools/check/tidy.py", *sorted(reached(path, tree))]:
        digest.update(f"\0{name}\0{tree.get(name, '')}".encode())
    return digest.hexdigest()[:24] + ".json"


def read_one(path, folder=Path(".")):
    """Findings of one source; paths in them are relative to the root."""
    run = subprocess.run(["clang-tidy", "--quiet", path, "--", *flags_of(path)], cwd=folder,
                         capture_output=True, text=True)
    root = str(folder.resolve()) + os.sep
    found = [WARNING.match(line) for line in run.stdout.splitlines()]
    findings = [f"{os.path.normpath(m[1].removeprefix(root))}:{m[2]}: {m[3]}" for m in found if m]
    if run.returncode and not findings:
        findings = [f"{path}:1: clang-tidy failed: {(run.stderr or run.stdout).strip()[-200:]}"]
    return findings


def changed(sources, tree, commits):
    """Those of the sources that the last commits changed; for a header one source that has it."""
    log = subprocess.run(["git", "log", f"-{commits}", "--format=", "--name-only"], check=True,
                         capture_output=True, text=True).stdout
    names = {name for name in log.splitlines() if name in tree}
    chosen = {path for path in sources if path in names}
    headers = {name for name in names if name.endswith(".h")}
    for path in chosen:
        headers -= reached(path, tree)
    for header in sorted(headers):
        own = header.removesuffix(".h") + ".cc"
        users = [own] * (own in tree) or [path for path in sources if header in reached(path, tree)]
        chosen.update(users[:1])
    return [path for path in sources if path in chosen]


def check(tree, options):
    cache = Path(options.work) / "tidy"
    cache.mkdir(exist_ok=True)
    # Tests and benches are left out: the macros of their libraries are not ours to name.
    sources = [p for p in tree if p.endswith(".cc") and not p.startswith("tests/")
               and not re.search(r"_(test|bench)\.cc$", p)]
    if options.commits:
        sources = changed(sources, tree, options.commits)

    def verdict(path):
        kept = cache / verdict_name(path, tree)
        if not kept.exists():
            part = kept.with_suffix(f".{os.getpid()}")
            part.write_text(json.dumps(read_one(path)))
            part.replace(kept)  # whole or not at all: .ci/run ends this at any time
        kept.touch()
        return kept.name, json.loads(kept.read_text())

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        verdicts = list(pool.map(verdict, sources))
    current = {name for name, _ in verdicts}
    for old in cache.glob("*.json"):
        if old.name not in current:
            old.unlink(missing_ok=True)
    # A header is read with every source that includes it: each finding once.
    return sorted({finding for _, findings in verdicts for finding in findings})


def self_test(options):
    folder = Path(options.work) / "tidy_self_test"
    folder.mkdir(exist_ok=True)
    (folder / ".clang-tidy").write_text(Path(".clang-tidy").read_text())
    bad = {
        "a function BadName": "void BadName() {}",
        "a variable badName": "int f() { int badName = 1; return badName; }",
        "a type bad_type": "struct bad_type {};",
        "a member without its _": "class A { public: int f() { return x; } private: int x = 0; };",
        "a constant without its k": "constexpr int kelvin_max = 3; constexpr int Max = 4;",
        "use after move": "#include <utility>\nstruct S { S(S&&); int x; };\nvoid g(S);\n"
                          "int f(S s) { g(std::move(s)); return s.x; }",
        "integer division": "double f(int a) { return 0.5 * (a / 2); }",
        AARCH64: "#ifdef __aarch64__\nvoid BadName() {}\n#endif",
    }
    good = ("struct SE3 { int R_WB = 0; };\nconstexpr int kTracksMax = 4;\n"
            "constexpr unsigned kImuFifo_us = 10;\nenum class Gate { kChi2 };\n"
            "int f(int R_WB, int T_BC0, int p_WL, int w_B) {\n"
            "  const int J_p = 1;\n  const int Jr = 2;\n  const int R_C1C0 = 3, R_aW = 4;\n"
            "  return R_WB + T_BC0 + p_WL + w_B + J_p + Jr + R_C1C0 + R_aW;\n}\n")
    cases = {**bad, "good": good}
    paths = {}
    for number, (what, text) in enumerate(cases.items()):
        paths[what] = f"{BARE[0] if what == AARCH64 else ''}case_{number}.cc"
        (folder / paths[what]).parent.mkdir(parents=True, exist_ok=True)
        (folder / paths[what]).write_text(text + "\n")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = dict(zip(paths, pool.map(lambda p: read_one(p, folder), paths.values())))
    blind = [what for what in bad if not found[what]]
    return blind + [f"that this is fine: {finding}" for finding in found["good"]]
