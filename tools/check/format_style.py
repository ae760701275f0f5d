"""Every source is as clang-format writes it; `make format` repairs."""
import re
import subprocess

WARNING = re.compile(r"^(.*?):(\d+):\d+: (?:warning|error): .*\[-Wclang-format")


def check(tree, options):
    del options
    sources = [path for path in tree if path.endswith((".h", ".cc"))]
    if not sources:
        return []
    run = subprocess.run(["clang-format", "--dry-run", "--ferror-limit=1", *sources],
                         capture_output=True, text=True)
    found = [WARNING.match(line) for line in run.stderr.splitlines()]
    if run.returncode and not any(found):
        return [f"clang-format failed: {run.stderr[:200]}"]
    return [f"{m[1]}:{m[2]}: not formatted; run make format" for m in found if m]


def self_test(options):
    del options
    for text, clean in (("int  f( ){return 1;}\n", False), ("int f() { return 1; }\n", True)):
        run = subprocess.run(["clang-format", "--dry-run", "--assume-filename=a.cc"], input=text,
                             capture_output=True, text=True)
        if ("clang-format" in run.stderr) == clean:
            return ["a badly formatted line" if not clean else "that a formatted line is fine"]
    return []
