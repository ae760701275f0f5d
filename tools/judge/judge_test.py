"""Tests of the judge's parts without any recording.

python3 -m unittest discover -s tools/judge -p '*_test.py'
"""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import math
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import figures  # noqa: E402
import page  # noqa: E402
import recordings  # noqa: E402
import runs  # noqa: E402
import table  # noqa: E402

TABLE = """
# name   kind    part     starts  options           source
clip     clip    decide   0,0.5   -                 data euroc_clip
fly      flight  confirm  0       --mono            sim --seed 3 --duration 4
fly.two  two     mode     0       "--cores 2"       as fly
"""


def summary(ate_m, tracked=90, lost=0, status="tracked"):
    evaluation = None
    if ate_m is not None:
        evaluation = {"ate_rmse_m": ate_m, "rpe_m": 0.004, "rpe_deg": None, "tilt_at_end_deg": 0.5}
    return {"status": status, "revision": "abc", "evaluation": evaluation, "nees": None,
            "frames": {"in": 100, "tracked": tracked, "lost": lost, "dropped": 0,
                       "before_start": 100 - tracked - lost},
            "timing_ms": {"end_to_end_ms": {"mean": 2.5}},
            "counters": {"adjustments": 12, "adjustments_failed": 1}}


def measured(*ates_m):
    return [figures.of_run(summary(ate_m)) for ate_m in ates_m]


class FiguresTest(unittest.TestCase):
    def test_reads_a_summary(self):
        run = figures.of_run(summary(0.0123, tracked=80, lost=20))
        self.assertAlmostEqual(run["ate_mm"], 12.3)
        self.assertAlmostEqual(run["rpe_mm"], 4)
        self.assertEqual(run["coverage"], 0.8)
        self.assertEqual((run["tilt_at_end"], run["tilt_at_10_s"]), (0.5, None))
        self.assertEqual((run["adjustments_failed"], run["nees_position"]), (1, None))

    def test_a_run_without_evaluation_is_the_worst(self):
        some = measured(0.001, None, 0.003)
        self.assertEqual(figures.figure(some, "ate_mm"), (3, 1, math.inf, 3))
        self.assertEqual(figures.figure(measured(None, None, 0.003), "ate_mm").median, math.inf)
        self.assertEqual(figures.of_run(summary(None, tracked=0))["coverage"], 0)

    def test_medians_of_odd_even_and_failed(self):
        self.assertEqual(figures.median([3, 1, 2]), 2)
        self.assertEqual(figures.median([4, 1, 2, 3]), 2.5)
        self.assertEqual(figures.median([1, math.inf, math.inf, 2]), math.inf)
        self.assertEqual(figures.median([math.inf, math.inf]), math.inf)
        self.assertIsNone(figures.figure(measured(0.001), "nees_position"))

    def test_ratio_says_nothing_of_zero_failed_and_missing(self):
        self.assertEqual(figures.ratio(1, 2), 0.5)
        for pair in ((0, 1), (1, 0), (math.inf, 1), (1, math.inf), (None, 1), (1, None)):
            self.assertIsNone(figures.ratio(*pair))

    def test_verdict_needs_ranges_apart(self):
        low, middle, high = (figures.Figure(m, m - 1, m + 1, 3) for m in (2, 3, 6))
        self.assertEqual(figures.verdict(low, high), 1)
        self.assertEqual(figures.verdict(high, low), -1)
        self.assertEqual(figures.verdict(low, middle), 0)
        self.assertEqual(figures.verdict(low, None), 0)
        self.assertEqual(figures.verdict(low._replace(runs=2), high), 0)

    def test_rows_of_one_recording_weigh_as_one(self):
        found = figures.mean_ratio([("a", 2), ("a", 2), ("a", 2), ("b", 0.5), ("c", None)])
        self.assertAlmostEqual(found.change, 1)
        self.assertEqual(found.recordings, 2)

    def test_the_band_is_that_of_the_mean_of_logarithms(self):
        found = figures.mean_ratio([("a", math.exp(0.1)), ("b", math.exp(0.3))])
        self.assertAlmostEqual(math.log(found.change), 0.2)
        self.assertAlmostEqual(math.log(found.high), 0.2 + 1.96 * 0.1)
        self.assertAlmostEqual(math.log(found.low), 0.2 - 1.96 * 0.1)
        self.assertIsNone(figures.mean_ratio([("a", 2)]).low)
        self.assertIsNone(figures.mean_ratio([("a", None)]))


class RecordingsTest(unittest.TestCase):
    def test_reads_the_table(self):
        rows = recordings.read_table(TABLE)
        self.assertEqual([row.name for row in rows], ["clip@0", "clip@0.5", "fly", "fly.two"])
        self.assertEqual(rows[1].start_s, 0.5)
        self.assertEqual({rows[0].recording, rows[1].recording}, {"clip"})
        self.assertEqual((rows[3].recording, rows[3].options), ("fly", ["--cores", "2"]))
        self.assertEqual(rows[3].source, ["sim", "--seed", "3", "--duration", "4"])

    def test_refuses_what_is_no_table(self):
        for text in ("clip clip decide 0 -", "clip clip perhaps 0 - data x", "a b decide 0 - as c",
                     "a b decide 0 - data x\na b decide 0 - data x"):
            with self.assertRaises(recordings.TableError):
                recordings.read_table(text)

    def test_the_set_holds_what_it_should(self):
        rows = recordings.read_table((HERE / "recordings.txt").read_text(encoding="utf-8"))
        motions = ("flight", "hover", "loop", "handheld", "vehicle")
        flights = [row for row in rows if row.kind in motions and row.part != "mode"]
        self.assertEqual(len(flights), 20)
        seeds = [row.source[row.source.index("--seed") + 1] for row in flights]
        self.assertEqual(len(set(seeds)), 20)
        for motion in motions:
            decide = [row for row in flights if (row.kind, row.part) == (motion, "decide")]
            self.assertEqual(len(decide), 2, motion)
            for option in ("ironsides", "--dark", "--imu-as-expected"):
                self.assertEqual(sum(option in row.source for row in decide), 1, motion + option)
        self.assertEqual(sum(row.kind == "still" for row in rows), 5)

    def test_a_missing_recording_has_a_reason(self):
        rows = recordings.read_table(TABLE + "hall drawn decide 0 - given HALL")
        with tempfile.TemporaryDirectory() as folder:
            places = recordings.Places({"PIRVS_DATA": folder, "EVAL_DATA": folder})
            self.assertIn("PIRVS_DATA", places.find(rows[0])[1])
            self.assertIn("EVAL_HYBRID", places.find(rows[-1])[1])
            (Path(folder) / "euroc_clip/mav0").mkdir(parents=True)
            self.assertIsNone(places.find(rows[0])[1])
            self.assertEqual(places.find(rows[3])[0], Path(folder) / "fly")

    def test_what_was_drawn_otherwise_is_not_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertFalse(recordings.is_drawn(Path(folder), ["--seed", "3"]))
            (Path(folder) / recordings.DRAWN).write_text(json.dumps({"options": ["--seed", "3"]}))
            self.assertTrue(recordings.is_drawn(Path(folder), ["--seed", "3"]))
            self.assertFalse(recordings.is_drawn(Path(folder), ["--seed", "4"]))


PROGRAM = """#!/bin/sh
while [ "$1" != --out ]; do shift; done
echo run >> "$(dirname "$0")/count"
mkdir -p "$2" && cp "$(dirname "$0")/summary.json" "$2" && touch "$2/state.csv"
exit STATUS
"""


class RunsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.at = Path(self.folder.name)
        (self.at / "summary.json").write_text(json.dumps(summary(0.01)))
        self.rows = recordings.read_table("a a decide 2 - data x\nb b mode 0 '--cores 2' as a")
        for path in ("imu0", "cam0"):
            (self.at / "x/mav0" / path).mkdir(parents=True)
            lines = [f"{1_000_000_000 + i * 50_000_000},f.png\n" for i in range(20)]
            (self.at / "x/mav0" / path / "data.csv").write_text("#stamp\n" + "".join(lines))

    def tearDown(self):
        self.folder.cleanup()

    def jobs(self, status=0):
        program = self.at / "program"
        program.write_text(PROGRAM.replace("STATUS", str(status)))
        program.chmod(0o755)
        folders = {row.name: self.at / "x" for row in self.rows}
        return list(runs.jobs(self.rows, folders, str(program), self.at / "out", lambda row: 3))

    def count(self):
        return (self.at / "count").read_text().count("run")

    def test_starts_lie_a_frame_apart(self):
        starts = [job.command[job.command.index("--start") + 1] for job in self.jobs()]
        self.assertEqual(starts[:3], ["2.000000", "2.050000", "2.100000"])
        self.assertEqual([job.alone for job in self.jobs()], [False] * 3 + [True] * 3)

    def test_what_was_run_is_not_run_again(self):
        runs.execute_all(self.jobs(), 2, lambda *words: None)
        runs.execute_all(self.jobs(), 2, lambda *words: None)
        self.assertEqual(self.count(), 6)
        self.assertEqual(len(runs.results(self.jobs())["rows"]["a"]), 3)
        runs.execute_all(self.jobs(status=1), 2, lambda *words: None)  # another program
        self.assertEqual(self.count(), 12)
        self.assertFalse((self.at / "out/runs/a/0/state.csv").exists())

    def test_a_run_that_cannot_be_made_is_told(self):
        with self.assertRaises(runs.RunError):
            runs.execute_all(self.jobs(status=2), 2, lambda *words: None)


class TableTest(unittest.TestCase):
    def setUp(self):
        self.rows = recordings.read_table(TABLE)
        self.after = {"clip@0": measured(0.001, 0.002, 0.003), "clip@0.5": measured(0.004),
                      "fly": measured(0.01, None), "fly.two": measured(0.02)}
        self.before = {"clip@0": measured(0.01, 0.02, 0.03), "clip@0.5": measured(0.004)}

    def test_fits_a_screen_and_says_what_changed(self):
        text = table.text(self.rows, self.after, self.before)
        lines = text.splitlines()
        self.assertIn("2.00      1.00..3.00", lines[1])
        self.assertTrue(lines[1].endswith("20.00  better"))
        self.assertIn("lost", lines[3])
        decide = next(line for line in lines if line.startswith("decide"))
        self.assertIn("x0.316", decide)  # a tenth and the same: one recording
        self.assertLess(max(map(len, lines)), 170)

    def test_another_way_stands_against_the_plain_one(self):
        rows = recordings.read_table(TABLE.replace("--mono", "-"))
        after = dict(self.after, fly=measured(0.01))
        _, lines = table.modes(rows, after)
        self.assertEqual(lines, [["two", "x2.000", "x1.000", "0 of 1"]])

    def test_the_page_is_whole(self):
        for before in (None, self.before):
            text = page.page(self.rows, self.after, before, "a & b")
            self.assertIn("a &amp; b", text)
            self.assertEqual(text.count("<svg"), text.count("</svg>"))
            self.assertNotIn("nan", text)
            self.assertEqual("before" in text, before is not None)


class JudgeTest(unittest.TestCase):
    def test_leaves_out_what_is_missing_and_says_so(self):
        loader = importlib.machinery.SourceFileLoader("judge", str(HERE / "judge"))
        judge = importlib.util.module_from_spec(
            importlib.util.spec_from_loader("judge", loader))
        loader.exec_module(judge)
        rows = recordings.read_table(TABLE)
        self.assertEqual([row.name for row in judge.chosen(rows, "two,clip")],
                         ["clip@0", "clip@0.5", "fly.two"])
        with self.assertRaises(recordings.TableError):
            judge.chosen(rows, "flies")
        with tempfile.TemporaryDirectory() as folder, io.StringIO() as said:
            with contextlib.redirect_stdout(said):
                left, _ = judge.found(rows, recordings.Places({"PIRVS_DATA": folder}))
            self.assertEqual([row.name for row in left], ["fly", "fly.two"])
            self.assertIn("left out: clip@0 clip@0.5: no recording at", said.getvalue())


if __name__ == "__main__":
    unittest.main()
