"""Poses of a run against the truth: errors, lies, and what confidence said of them."""

import bisect
import collections
import math

from recording import NS, rows_of

SURE = 0.6           # confidence above it
WRONG_M = 0.15       # an error above it and above
WRONG_SIGMAS = 3
ALLOWED_S = 0.2      # after a fault begins
ROWS_OF_COV = {(i, j): sum(9 - k for k in range(i)) + j - i for i in range(9) for j in range(i, 9)}

Frame = collections.namedtuple("Frame", "t_s error sigma confidence reasons health")
Verdict = collections.namedtuple("Verdict", "frames lies error_max error_end sigma_end confidence "
                                            "confidence_min reasons")


def yaw_of(q):
    w, x, y, z = q
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def times(a, b):
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw)


def conjugate(q):
    return q[0], -q[1], -q[2], -q[3]


def truth_at(stamps, truth, t):
    """Place by a line between neighbours, attitude of the earlier; None outside."""
    k = bisect.bisect_right(stamps, t) - 1
    if k < 0 or k + 1 >= len(stamps):
        return None
    share = (t - stamps[k]) / (stamps[k + 1] - stamps[k])
    a, b = truth[k], truth[k + 1]
    return [a[1 + i] + share * (b[1 + i] - a[1 + i]) for i in range(3)], a[4:8]


def frames_of(state_csv, recording):
    """The run laid on the truth by place and heading at its first pose."""
    with open(state_csv) as file:
        column = {name: k for k, name in enumerate(file.readline().lstrip("#").strip().split(","))}
    stamps = [row[0] for row in recording.truth]
    begin = recording.cameras[0][0][0]
    frames, first = [], None
    for row in rows_of(state_csv):
        t = int(row[0])
        true = truth_at(stamps, recording.truth, t)
        if true is None:
            continue
        p = [float(v) for v in row[2:5]]
        x, y, z, w = (float(v) for v in row[5:9])
        if first is None:
            yaw = yaw_of(times(true[1], conjugate((w, x, y, z))))
            first = p, true[0], math.cos(yaw), math.sin(yaw)
        p0, q0, cos, sin = first
        d = [p[i] - p0[i] for i in range(3)]
        at = cos * d[0] - sin * d[1] + q0[0], sin * d[0] + cos * d[1] + q0[1], d[2] + q0[2]
        error = math.dist(at, true[0])
        cov = [float(row[column["cov00"] + ROWS_OF_COV[i, i]]) for i in range(3, 6)]
        frames.append(Frame((t - begin) / NS, error, math.sqrt(max(0.0, sum(cov))),
                            float(row[column["confidence"]]), row[column["reasons"]], row[1]))
    return frames


def wrong(frame):
    return frame.error > max(WRONG_M, WRONG_SIGMAS * frame.sigma)


def judge(frames, fault_s):
    if not frames:
        return None
    counted = [f for f in frames
               if fault_s is None or not fault_s <= f.t_s < fault_s + ALLOWED_S]
    lies = sum(f.confidence > SURE and wrong(f) for f in counted)
    reasons = collections.Counter(word for f in frames for word in f.reasons.split("+")
                                  if word and word != "0")
    return Verdict(len(frames), lies / max(1, len(counted)), max(f.error for f in frames),
                   frames[-1].error, frames[-1].sigma,
                   sum(f.confidence for f in frames) / len(frames),
                   min(f.confidence for f in frames), [r for r, _ in reasons.most_common()])


def undisturbed(case, frames):
    """Those of a case at which nothing is wrong with the sensors, now or before."""
    if case.kind == 0:
        return frames
    return [f for f in frames if case.fault_s is not None and f.t_s < case.fault_s]


def roc(good, bad):
    """[(threshold, share of good frames below it, share of wrong ones below it)]"""
    good = sorted(f.confidence for f in good if not wrong(f))
    bad = sorted(f.confidence for f in bad if wrong(f))
    return [(k / 100, bisect.bisect_left(good, k / 100) / max(1, len(good)),
             bisect.bisect_left(bad, k / 100) / max(1, len(bad))) for k in range(0, 102)]


def caught(curve, doubted_max=0.01):
    """The share of wrong frames below the highest threshold that doubts so few good ones."""
    return max(point[2] for point in curve if point[1] <= doubted_max)
