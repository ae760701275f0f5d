"""Where the recordings of EuRoC, TUM-VI and PennCOSYVIO lie below a folder, and their truths."""

import collections
import sys
from pathlib import Path

import published

sys.path.append(str(Path(__file__).resolve().parent.parent / "lib"))
from rotation import quaternion

# truth: a file for `pirvs eval`, or a rig's matrices that must be taken to the IMU first.
Sequence = collections.namedtuple("Sequence", "name folder options truth rig_truth")


class Missing(Exception):
    """One line: what is not there, and where it was looked for."""


def _below(root, names):
    """The first of these paths that is there."""
    for name in names:
        if (Path(root) / name).exists():
            return Path(root) / name
    raise Missing(f"not at {Path(root) / names[0]}")


def _asl(root, name, groups, truths, calibration=None):
    folder = _below(root, [name, *(f"{group}/{name}" for group in groups)])
    mav0 = folder / "mav0"
    if not (mav0 / "imu0").is_dir():
        raise Missing(f"{folder} has no mav0/imu0")
    truth = next((mav0 / t for t in truths if (mav0 / t).exists()), None)
    if truth is None:
        raise Missing(f"{mav0} has no truth ({', '.join(truths)})")
    options = ["--calib", str(_below(folder, calibration))] if calibration else []
    return Sequence(name, folder, options, truth, False)


def euroc(root, name):
    return _asl(root, name, ("machine_hall", "vicon_room1", "vicon_room2"),
                ("state_groundtruth_estimate0/data.csv",))


def tum_vi(root, name):
    return _asl(root, name, ("512_16",), ("mocap0/data.csv",), ["dso/camchain.yaml"])


def penncosyvio(root, name):
    """As its download script leaves it: visensor/as with a bag or frames, ground_truth/as/pose.txt.

    Calibration: Kalibr's camchain-imucam.yaml beside them, or its documents' visensor_calib.
    """
    root = Path(root)
    folder = _below(root, [f"visensor/{name}", f"data/visensor/{name}", name])
    truth = _below(root, [f"ground_truth/{name}/pose.txt", f"data/ground_truth/{name}/pose.txt",
                          f"{folder.relative_to(root)}/pose.txt"])
    chains = [path for place in (folder, folder.parent, root)
              for path in sorted(place.glob("*camchain*.yaml"))]
    if not chains:
        raise Missing(f"{root} has no *camchain*.yaml of the VI sensor")
    bags = sorted(folder.glob("*.bag"))
    return Sequence(f"PennCOSYVIO {name.upper()}", bags[0] if bags else folder,
                    ["--calib", str(chains[0])], truth, True)


def find(roots):
    """(sequences, {name: why it is missing}); a data set without a folder is not looked for."""
    found, missing = [], {}
    sets = (("euroc", euroc, published.EUROC), ("tumvi", tum_vi, published.TUM_VI),
            ("penncosyvio", penncosyvio, published.PENNCOSYVIO))
    for key, of, names in sets:
        for name in names if roots.get(key) else ():
            try:
                found.append(of(roots[key], name))
            except Missing as why:
                missing[name] = str(why)
    return found, missing


def truth_of_imu(path):
    """PennCOSYVIO's poses of its rig as TUM lines of the IMU: T_WI = T_WB inverse(T_IB)."""
    R = [row[:3] for row in published.RIG_TO_IMU]
    t = [row[3] for row in published.RIG_TO_IMU]
    p_BI = [-sum(R[k][i] * t[k] for k in range(3)) for i in range(3)]
    lines = []
    for line in Path(path).read_text().splitlines():
        words = [float(word) for word in line.split()]
        if len(words) != 13:
            continue
        m = [words[1 + 4 * i:5 + 4 * i] for i in range(3)]
        R_WI = [[sum(m[i][k] * R[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
        p = [m[i][3] + sum(m[i][k] * p_BI[k] for k in range(3)) for i in range(3)]
        lines.append(" ".join(f"{v:.9f}" for v in (words[0], *p, *quaternion(R_WI))))
    return "\n".join(lines) + "\n"
