"""Sweeps with a program that answers at once: what is run, what is run again, and one table."""

import csv
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import page
import plan
import slurm_node

HERE = Path(__file__).resolve().parent
SIM = "sim:--path loop"


class Sweeping(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        self.environment = {**os.environ, "FAKE_PIRVS": self.folder.name}

    def words(self, *more, out="out"):
        return [sys.executable, "-B", str(HERE / "sweep"), "--pirvs", str(HERE / "fake_pirvs.py"),
                "--out", str(self.root / out), "--jobs", "4", *more]

    def sweep(self, *more, out="out"):
        return subprocess.run(self.words(*more, out=out), env=self.environment,
                              capture_output=True, text=True, timeout=400)

    def calls(self):
        path = self.root / "calls"
        return len(path.read_text().split()) if path.exists() else 0

    def table(self, out="out"):
        with open(self.root / out / "sweep.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        return [row[:-len(page.OF_THE_MACHINE)] for row in rows]

    def kill_the_hanging(self, with_its_task):
        """Kills a run of seed 7, and its task, as a node that goes down would."""
        end = time.monotonic() + 120
        while not (self.root / "hanging").exists():
            self.assertLess(time.monotonic(), end, "the run of seed 7 never began")
            time.sleep(0.1)
        run = int((self.root / "hanging").read_text())
        task = int(Path(f"/proc/{run}/stat").read_text().rsplit(")", 1)[1].split()[1])
        (self.root / "HANG").unlink()
        for process in (task, run) if with_its_task else (run,):
            os.kill(process, signal.SIGKILL)

    def killed_and_resumed(self, out, *more):
        """Ten seeds by two values: one of the twenty is killed, and made by the second call."""
        (self.root / "HANG").touch()
        before = self.calls()
        words = ["--recording", SIM, "--seeds", "1-10", "--set", "a.b=1,2", *more]
        first = subprocess.Popen(self.words(*words, out=out), env=self.environment, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.kill_the_hanging(with_its_task="--slurm" in more)
        said, errors = first.communicate(timeout=400)
        self.assertEqual(first.returncode, 1, said + errors)
        self.assertIn("ended before its time" if "--slurm" in more else "status -9", errors)
        self.assertIn("19 of 20 runs", said)
        made = self.calls() - before
        again = self.sweep(*words, out=out)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertEqual(self.calls() - before - made, 1)
        self.assertEqual(len(self.table(out)), 21)
        (self.root / "hanging").unlink()

    def test_every_combination_is_run_once(self):
        words = ["--recording", "x=" + SIM, "--recording", "y=sim:--path rest", "--seeds", "1-3",
                 "--set", "a.b=1,2", "--set", "c.d=5,6"]
        done = self.sweep(*words)
        self.assertEqual(done.returncode, 0, done.stderr)
        table = self.table()
        self.assertEqual(table[0][:4], ["recording", "a.b", "c.d", "seed"])
        self.assertEqual(len({tuple(row[:4]) for row in table[1:]}), 24)
        self.assertEqual(len({row[table[0].index("ate_mm")] for row in table[1:]}), 24)
        self.assertEqual(self.calls(), 24)
        self.assertEqual(len(list((self.root / "out/recordings").glob("*/words"))), 6)
        self.assertFalse(list((self.root / "out").rglob("trace.json")))
        self.assertIn("<svg", (self.root / "out/sweep.html").read_text())
        grown = self.sweep(*words[:-1], "c.d=5,6,7")
        self.assertEqual(grown.returncode, 0, grown.stderr)
        self.assertEqual(self.calls(), 36)

    def test_killed_and_resumed_on_this_machine(self):
        self.killed_and_resumed("out")

    def test_what_cannot_run_is_told_and_tried_again(self):
        for _ in range(2):
            done = self.sweep("--recording", SIM, "--set", "bad.value=0,1")
            self.assertEqual(done.returncode, 1)
            self.assertIn("no such parameter: bad.value", done.stderr)
        self.assertEqual(self.calls(), 1)
        self.assertIn("exit status 2", self.table()[2][3])

    def test_usage(self):
        for words in (["--recording", "nowhere"], ["--recording", SIM, "--seeds", "5-1"],
                      ["--recording", SIM, "--set", "a.b"], [], ["--recording", SIM + " --seed 3"],
                      ["--recording", SIM, "--recording", SIM]):
            done = self.sweep(*words)
            self.assertEqual(done.returncode, 2, words)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)

    def test_a_later_seed_starts_a_frame_later(self):
        data = self.root / "rec/mav0/cam0"
        data.mkdir(parents=True)
        (data / "data.csv").write_text("".join(f"{k * 50_000_000},x\n" for k in range(20)))
        done = self.sweep("--recording", str(self.root / "rec"), "--seeds", "1,4")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = [path.read_text() for path in (self.root / "out/jobs").rglob("summary.json")]
        self.assertEqual(sum("--start 0.150000" in text for text in told), 1)

    @unittest.skipUnless(os.environ.get("PIRVS_NIGHTLY"), "for make nightly")
    @unittest.skipIf(slurm_node.missing(), "no slurm-wlm here")
    def test_a_cluster_of_one_node_gives_the_same_table(self):
        words = ["--recording", SIM, "--seeds", "1-10", "--set", "a.b=1,2"]
        self.assertEqual(self.sweep(*words, out="local").returncode, 0)
        with slurm_node.node(self.root / "slurm") as self.environment:
            self.environment["FAKE_PIRVS"] = self.folder.name
            self.killed_and_resumed("cluster", "--slurm")
        self.assertEqual(self.table("cluster"), self.table("local"))


class Words(unittest.TestCase):
    def test_seeds(self):
        self.assertEqual(plan.seeds("1-3,8,2"), [1, 2, 3, 8])

    def test_recordings(self):
        self.assertEqual(plan.recording("a=sim:--gnss rtk"), ("a", "sim:--gnss rtk"))
        self.assertEqual(plan.recording("sim:--gnss=rtk"), ("sim", "sim:--gnss=rtk"))


if __name__ == "__main__":
    unittest.main()
