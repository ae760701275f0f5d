"""The rows of an ASL folder's tables, up to a duration, in the order of time, for the writers here.

Each is (stamp in ns, "left", "right", "imu" or "truth", content).
"""
from pathlib import Path


def table(path):
    for line in Path(path).read_text().splitlines():
        if line and line[0] != "#":
            yield line.strip().split(",")


def rows(folder, duration_s):
    mav0 = Path(folder) / "mav0"
    first = int(next(table(mav0 / "cam0/data.csv"))[0])
    out = []
    for camera, name in (("cam0", "left"), ("cam1", "right")):
        for t, file in (row[:2] for row in table(mav0 / camera / "data.csv")):
            out.append((int(t), name, (mav0 / camera / "data" / file.strip()).read_bytes()))
    for row in table(mav0 / "imu0/data.csv"):
        out.append((int(row[0]), "imu", [float(word) for word in row[1:7]]))
    for row in table(mav0 / "state_groundtruth_estimate0/data.csv"):
        out.append((int(row[0]), "truth", [float(word) for word in row[1:8]]))
    out = [row for row in out if row[0] <= first + int(duration_s * 1e9)]
    return sorted(out, key=lambda row: row[0])
