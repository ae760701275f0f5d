"""An ASL recording that is read, spoiled and written again; its images are linked."""

import math
import random
import re
import shutil
from pathlib import Path

NS = 1_000_000_000


def rows_of(path):
    with open(path) as file:
        return [line.strip().split(",") for line in file if line.strip() and line[0] != "#"]


class Recording:
    """imu: [t_ns, w, f]; cameras: [[t_ns, file]]; truth: [t_ns, p, q wxyz, ...]."""

    def __init__(self, folder):
        self.folder = Path(folder).resolve()
        mav = self.folder / "mav0"
        self.imu = [[int(r[0]), *map(float, r[1:7])] for r in rows_of(mav / "imu0/data.csv")]
        self.truth = [[int(r[0]), *map(float, r[1:])]
                      for r in rows_of(mav / "state_groundtruth_estimate0/data.csv")]
        self.cameras = [[[int(r[0]), r[1].strip()] for r in rows_of(mav / f"cam{c}/data.csv")]
                        for c in (0, 1)]
        self.yaml = [(mav / f"cam{c}/sensor.yaml").read_text() for c in (0, 1)]
        self.imu_yaml = (mav / "imu0/sensor.yaml").read_text()

    def seconds(self, t):
        return (t - self.cameras[0][0][0]) / NS

    def spoil_imu(self, change):
        """change(seconds, [wx, wy, wz, fx, fy, fz]) -> the same, changed."""
        self.imu = [[row[0], *change(self.seconds(row[0]), row[1:])] for row in self.imu]

    def turn_camera(self, c, axis, angle):
        """Claims that camera `c` stands turned about its own axis by so much more than it does."""
        found = re.search(r"data:\s*\[([^\]]*)\]", self.yaml[c])
        T = [float(word) for word in found[1].split(",")]
        i, j = [k for k in range(3) if k != axis]
        cos, sin = math.cos(angle), math.sin(angle)
        for row in range(3):
            a, b = T[4 * row + i], T[4 * row + j]
            T[4 * row + i], T[4 * row + j] = cos * a + sin * b, cos * b - sin * a
        text = ", ".join(f"{value:.12g}" for value in T)
        self.yaml[c] = self.yaml[c][:found.start(1)] + text + self.yaml[c][found.end(1):]

    def write(self, out):
        out = Path(out)
        shutil.rmtree(out, ignore_errors=True)
        mav = out / "mav0"
        for name in ("imu0", "state_groundtruth_estimate0", "cam0", "cam1"):
            (mav / name).mkdir(parents=True)
        (mav / "imu0/sensor.yaml").write_text(self.imu_yaml)
        table(mav / "imu0/data.csv", self.imu)
        table(mav / "state_groundtruth_estimate0/data.csv", self.truth)
        for c in (0, 1):
            (mav / f"cam{c}/sensor.yaml").write_text(self.yaml[c])
            table(mav / f"cam{c}/data.csv", self.cameras[c])
            (mav / f"cam{c}/data").symlink_to(self.folder / f"mav0/cam{c}/data")
        return out


def table(path, rows):
    with open(path, "w") as file:
        file.write("#timestamp [ns]\n")
        for row in rows:
            file.write(",".join(f"{v:.9f}" if isinstance(v, float) else str(v) for v in row) + "\n")


def motors(force, rate, begin=-math.inf, seed=3):
    """Two tones, their beat and noise on every axis: for Recording.spoil_imu."""
    noise = random.Random(seed)
    phases = [noise.uniform(0, 6) for _ in range(6)]

    def change(t, row):
        on = min(1.0, max(0.0, t - begin))
        out = list(row)
        for k, size in enumerate((rate, rate, rate, force, force, force)):
            axis = k % 3
            tone = math.sin(2 * math.pi * (87.3 + 3.1 * axis) * t + phases[k])
            beat = 0.5 * math.sin(2 * math.pi * (61.7 - 2 * axis) * t + phases[(k + 1) % 6])
            out[k] += on * size * (tone + beat + noise.gauss(0, 0.3))
        return out

    return change
