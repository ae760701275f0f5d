"""Packages of programs that only say --help: the same bytes twice, lintian, completion, the bill.

The true programs are installed into a fresh Debian root by tools/deb/try_install, on purpose alone.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import completion
import contents

HERE = Path(__file__).resolve().parent
HELP = """Does things.
Usage: pirvs [OPTIONS] SUBCOMMAND

Options:
  -h,--help                   Print this help message and exit

Subcommands:
  run                         Run it on a recording
"""
RUN = """Run it on a recording
Usage: pirvs run [OPTIONS] SEQ

Options:
  -h,--help                   Print this help message and exit
  --out TEXT REQUIRED         folder for the results
  --set TEXT ...              name=value, a parameter [of those]
  --cameras INT:INT in [0 - 15]
                              LEFT,RIGHT, isn't it
"""
SOURCE = """#include <string.h>
#include <stdio.h>
int main(int n, char** words) {
  (void)n;
  return fputs(n > 1 && !strcmp(words[1], "run") ? RUN : HELP, stdout) < 0;
}
"""


def build_programs(folder):
    """Real programs, small: strip and dpkg-shlibdeps want ELF."""
    source = Path(folder) / "a.c"
    source.write_text(f"#define HELP {json.dumps(HELP)}\n#define RUN {json.dumps(RUN)}\n{SOURCE}")
    for name in ("pirvs", "pirvsd", "pirvs-usb"):
        static = [] if name == "pirvs" else ["-static"]
        subprocess.run(["gcc", *static, source, "-o", Path(folder) / name], check=True)


def build_library(folder, names):
    """One that has the symbols of ours."""
    source = Path(folder) / "library.c"
    source.write_text("".join(f"void {name}(void) {{}}\n" for name in names))
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", Path(folder) / contents.LIBRARY,
                    f"-Wl,-soname,{contents.LIBRARY}",
                    f"-Wl,--version-script={HERE.parents[1] / 'board/library/exports.map'}"],
                   check=True)


def symbols():
    lines = (HERE / "libpirvs0.symbols").read_text().splitlines()[1:]
    return [line.split("@")[0].strip() for line in lines if line.startswith(" pirvs_")]


@unittest.skipUnless(os.environ.get("PIRVS_NIGHTLY"), "for make nightly")
@unittest.skipUnless(shutil.which("dpkg-deb") and shutil.which("help2man"), "no help2man here")
@unittest.skipUnless(os.uname().machine == "x86_64", "for amd64")
class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = Path(cls.folder.name)
        build_programs(cls.root)
        build_library(cls.root, symbols())

    def try_build(self, package, out, programs, umask=0o022):
        return subprocess.run(
            [sys.executable, "-B", HERE / "build", package, "--arch", "amd64", "--programs",
             programs, "--out", self.root / out, "--version", "1.2", "--time", "1700000000"],
            text=True, capture_output=True, umask=umask)

    def build(self, package, out, umask=0o022):
        done = self.try_build(package, out, self.root, umask)
        self.assertEqual(done.returncode, 0, done.stderr)
        name = f"{package}_1.2_amd64"
        return self.root / out / f"{name}.deb", self.root / out / f"{name}.spdx.json"

    def test_two_builds_give_the_same_bytes(self):
        for package in contents.PROGRAMS:
            one = self.build(package, "one")
            time.sleep(2)
            for path in self.root.glob("*pirvs*"):
                if path.is_file():
                    path.touch()
            two = self.build(package, "two", umask=0o077)
            for a, b in zip(one, two):
                self.assertEqual(a.read_bytes(), b.read_bytes(), a.name)

    def test_the_package_holds_what_people_expect(self):
        package, bill = self.build("pirvsd", "three")
        listed = subprocess.run(["dpkg-deb", "-c", package], text=True, capture_output=True).stdout
        for path in ("lib/systemd/system/pirvsd.service", "usr/share/man/man1/pirvsd.1.gz",
                     "etc/pirvs/pirvsd.cfg", "usr/share/bash-completion/completions/pirvs-usb",
                     "lib/udev/rules.d/60-pirvsd.rules",
                     "usr/share/zsh/vendor-completions/_pirvsd"):
            self.assertIn(f" ./{path}\n", listed)
        self.assertNotIn("/config/", contents.unit("pirvsd.service", HERE.parents[1]))
        told = json.loads(bill.read_text())
        self.assertEqual(told["spdxVersion"], "SPDX-2.3")
        names = {part["name"] for part in told["packages"]}
        self.assertLessEqual({"pirvsd", "libc6-dev", "libeigen3-dev"}, names)
        known = {part["SPDXID"] for part in told["packages"]} | {"SPDXRef-DOCUMENT"}
        for relation in told["relationships"]:
            self.assertLessEqual({relation["spdxElementId"], relation["relatedSpdxElement"]}, known)

    def test_the_library_has_the_symbols_that_programs_need(self):
        package, bill = self.build("libpirvs0", "five")
        listed = subprocess.run(["dpkg-deb", "-c", package], text=True, capture_output=True).stdout
        self.assertIn(f" ./{contents.LIBRARIES['amd64']}/libpirvs.so.0\n", listed)
        self.assertIn("SPDX-2.3", bill.read_text())
        shown = subprocess.run(["dpkg-deb", "-I", package, "symbols"], text=True,
                               capture_output=True).stdout
        for name in symbols():
            self.assertIn(f" {name}@PIRVS_0 ", shown)
        package, _ = self.build("libpirvs-dev", "five")
        listed = subprocess.run(["dpkg-deb", "-c", package], text=True, capture_output=True).stdout
        for path in ("usr/include/pirvs.h", "usr/share/doc/libpirvs-dev/examples/poses.py",
                     f"{contents.LIBRARIES['amd64']}/libpirvs.so -> libpirvs.so.0"):
            self.assertIn(f" ./{path}\n", listed)
        needs = subprocess.run(["dpkg-deb", "-f", package, "Depends"], text=True,
                               capture_output=True).stdout
        self.assertEqual(needs.strip(), "libpirvs0 (= 1.2)")
        with tempfile.TemporaryDirectory() as folder:
            build_library(folder, symbols()[1:])
            done = self.try_build("libpirvs0", "six", folder)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(symbols()[0], done.stderr)

    @unittest.skipUnless(shutil.which("lintian"), "no lintian here")
    def test_lintian_finds_no_error(self):
        done = subprocess.run(["lintian", "--fail-on", "error", "--allow-root",
                               self.build("pirvsd", "four")[0]], text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_completion(self):
        program = completion.Program(self.root / "pirvs")
        self.assertEqual(list(program.options(RUN)), ["--help", "--out", "--set", "--cameras"])
        self.assertEqual(program.options(RUN)["--cameras"], ("LEFT,RIGHT, isn't it", True))
        self.assertEqual(program.options(RUN)["--help"][1], False)
        (self.root / "bash").write_text(program.bash())

        def complete(*words):
            script = (f". {self.root}/bash; COMP_WORDS=({' '.join(words)}); "
                      f"COMP_CWORD={len(words) - 1}; _pirvs; echo ${{COMPREPLY[@]}}")
            return subprocess.run(["bash", "-c", script], text=True,
                                  capture_output=True).stdout.split()

        self.assertEqual(complete("pirvs", "r"), ["run"])
        self.assertEqual(complete("pirvs", "run", "--c"), ["--cameras"])
        self.assertEqual(complete("pirvs", "run", "some"), [])
        self.assertIn("isn'\\''t", program.zsh())
        if shutil.which("zsh"):
            (self.root / "zsh").write_text(program.zsh())
            subprocess.run(["zsh", "-n", self.root / "zsh"], check=True)


if __name__ == "__main__":
    unittest.main()
