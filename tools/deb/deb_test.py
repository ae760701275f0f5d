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

    def build(self, package, out, umask=0o022):
        done = subprocess.run(
            [sys.executable, "-B", HERE / "build", package, "--arch", "amd64", "--programs",
             self.root, "--out", self.root / out, "--version", "1.2", "--time", "1700000000"],
            text=True, capture_output=True, umask=umask)
        self.assertEqual(done.returncode, 0, done.stderr)
        name = f"{package}_1.2_amd64"
        return self.root / out / f"{name}.deb", self.root / out / f"{name}.spdx.json"

    def test_two_builds_give_the_same_bytes(self):
        for package in contents.PROGRAMS:
            one = self.build(package, "one")
            time.sleep(2)
            for path in self.root.glob("pirvs*"):
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
