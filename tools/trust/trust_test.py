"""What judge.py calls a lie, and what recording.py writes."""

import math
import tempfile
import unittest
from pathlib import Path

import judge
import page
from cases import BASES, CASES, Case
from judge import Frame
from recording import NS, Recording, motors

COLUMNS = (["t_ns", "health", "px", "py", "pz", "qx", "qy", "qz", "qw"]
           + [f"cov{i}{j}" for i in range(9) for j in range(i, 9)] + ["confidence", "reasons"])
YAML = "T_BS:\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"


def recording(folder):
    """Ten frames at 10 Hz along x at 1 m/s."""
    mav = Path(folder) / "mav0"
    for name in ("imu0", "state_groundtruth_estimate0", "cam0", "cam1"):
        (mav / name).mkdir(parents=True)
        (mav / name / "sensor.yaml").write_text(YAML)
    stamps = [k * NS // 10 for k in range(11)]
    (mav / "imu0/data.csv").write_text("".join(f"{t},0,0,0,0,0,9.81\n" for t in stamps))
    (mav / "state_groundtruth_estimate0/data.csv").write_text(
        "".join(f"{t},{t / NS},0,0,1,0,0,0\n" for t in stamps))
    for c in (0, 1):
        (mav / f"cam{c}/data.csv").write_text("".join(f"{t},{t}.png\n" for t in stamps))
    return Recording(folder)


def state_csv(path, off, sigma2, confidence):
    """A run along the truth, turned by 90 degrees and off by `off` from the fifth frame on."""
    rows = ["#" + ",".join(COLUMNS)]
    for k in range(10):
        y = k / 10 + (off if k >= 5 else 0)
        s = math.sqrt(0.5)
        cov = [sigma2 if i == j and 3 <= i < 6 else 0 for i in range(9) for j in range(i, 9)]
        rows.append(",".join(map(str, [k * NS // 10, "tracking", 0, y, 0, 0, 0, s, s, *cov,
                                       confidence, "blind+jumps" if k == 9 else ""])))
    Path(path).write_text("\n".join(rows) + "\n")


class Judging(unittest.TestCase):
    def verdict(self, off, sigma2, confidence, fault_s=None):
        with tempfile.TemporaryDirectory() as folder:
            state_csv(folder + "/state.csv", off, sigma2, confidence)
            frames = judge.frames_of(folder + "/state.csv", recording(folder))
        return judge.judge(frames, fault_s)

    def test_a_good_run_is_laid_on_the_truth(self):
        verdict = self.verdict(0, 1e-4, 1)
        self.assertLess(verdict.error_max, 1e-9)
        self.assertEqual((verdict.lies, verdict.frames), (0, 10))
        self.assertEqual(set(verdict.reasons), {"blind", "jumps"})

    def test_a_lie_is_sure_and_far_off(self):
        self.assertEqual(self.verdict(0.5, 1e-4, 1).lies, 0.5)
        self.assertEqual(self.verdict(0.5, 1e-4, 0.5).lies, 0)
        self.assertEqual(self.verdict(0.5, 0.04, 1).lies, 0)
        self.assertEqual(self.verdict(0.1, 1e-8, 1).lies, 0)

    def test_the_first_moment_of_a_fault_is_no_lie(self):
        self.assertEqual(self.verdict(0.5, 1e-4, 1, fault_s=0.45).lies, 3 / 8)

    def test_no_pose(self):
        self.assertIsNone(judge.judge([], None))

    def test_what_confidence_tells(self):
        good = [Frame(0, 0.01, 0.01, 0.9, "", "")] * 3
        bad = [Frame(0, 1.00, 0.01, c, "", "") for c in (0.1, 0.2, 0.95)]
        curve = {round(t * 100): (d, c) for t, d, c in judge.roc(good + bad, good + bad)}
        self.assertEqual(curve[50], (0, 2 / 3))
        self.assertEqual(curve[92], (1, 2 / 3))
        self.assertEqual(judge.caught(judge.roc(good, bad)), 2 / 3)
        self.assertIn("polyline", page.plot({"all": judge.roc(good, bad)}))

    def test_good_is_what_comes_before_the_fault(self):
        frames = [Frame(t, 0.01, 0.01, 1, "", "") for t in (1, 2, 3)]
        clean, spoiled, late = (Case("", kind, "", fault_s=s)
                                for kind, s in ((0, None), (3, None), (6, 2.5)))
        self.assertEqual([len(judge.undisturbed(case, frames)) for case in (clean, spoiled, late)],
                         [3, 0, 2])


class Cases(unittest.TestCase):
    def test_names_and_bases_are_there_once(self):
        self.assertEqual(len({case.name for case in CASES}), len(CASES))
        self.assertLessEqual({case.base for case in CASES}, set(BASES))

    def test_what_is_written_is_read(self):
        with tempfile.TemporaryDirectory() as folder:
            one = recording(folder + "/a")
            one.spoil_imu(motors(5, 1))
            one.turn_camera(1, 2, math.pi / 2)
            two = Recording(one.write(folder + "/b"))
            self.assertEqual(two.yaml[1].split("[")[1][:8].replace(" ", "")[:1], "6")
            self.assertEqual(two.yaml[0], YAML)
            for a, b in zip(one.imu, two.imu):
                self.assertEqual(a[0], b[0])
                for x, y in zip(a[1:], b[1:]):
                    self.assertAlmostEqual(x, y, places=8)


if __name__ == "__main__":
    unittest.main()
