"""The pages: commands that run, parameters that exist, links that lead somewhere.

PIRVS names the program (default build/host/pirvs); what needs it is skipped without it.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PIRVS = Path(os.environ.get("PIRVS", ROOT / "build/host/pirvs"))
has_program = unittest.skipUnless(PIRVS.exists(), f"no {PIRVS}")


def call(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True)


class Pages(unittest.TestCase):
    @unittest.skipUnless(os.environ.get("PIRVS_NIGHTLY"), "for make nightly")
    @has_program
    def test_a_newcomers_path_ends_with_poses_and_a_page(self):
        done = call(sys.executable, HERE / "try_commands", "--pirvs", PIRVS)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @has_program
    def test_a_command_that_fails_is_seen(self):
        try_commands = SourceFileLoader("try_commands", str(HERE / "try_commands")).load_module()
        lines = try_commands.commands("# A\n    true\n    make no  # such\n\ntext\n    so on\n")
        self.assertEqual(lines, ["true", "make no  # such"])
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(try_commands.run(["true", "false", "true"], PIRVS, folder)[0], 1)

    @has_program
    def test_parameters_of_the_pages_exist(self):
        known = {line.split()[0] for line in call(PIRVS, "params", "--all").stdout.splitlines()
                 if line.strip()}
        groups = {name.split(".")[0] for name in known}
        text = "".join((ROOT / "docs" / name).read_text()
                       for name in ("tune.md", "limits.md", "hardware.md", "first-steps.md"))
        named = {name for name in re.findall(r"\b([a-z]+\.[a-z_]+)\b", text)
                 if name.split(".")[0] in groups and "_" in name}
        self.assertGreater(len(named), 8)
        self.assertEqual(named - known, set())

    @unittest.skipUnless(shutil.which("mkdocs"), "no mkdocs here")
    def test_the_site_is_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            done = call(HERE / "build", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            broken = Path(folder) / "fleet.html"
            broken.write_text(broken.read_text().replace("conventions.html", "nowhere.html")
                              + '<script src="https://example.org/x.js"></script>')
            site = SourceFileLoader("site_build", str(HERE / "build")).load_module()
            wrong = " ".join(site.wrong_links(Path(folder).resolve()))
        self.assertIn("nowhere.html", wrong)
        self.assertIn("example.org", wrong)


if __name__ == "__main__":
    unittest.main()
