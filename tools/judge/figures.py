"""The figures of runs: what is taken from a summary, medians and ranges, before against after."""

import collections
import math

FAILED = math.inf  # the error of a run without an evaluation: worse than any other

RUNS_OF_A_RANGE = 3  # with fewer, a range says nothing

Figure = collections.namedtuple("Figure", "median low high runs")
# change: of the medians, after / before. low, high: its 95 % band over the recordings.
Ratio = collections.namedtuple("Ratio", "change low high recordings")


def _at(tree, *path):
    for name in path:
        tree = tree.get(name) if isinstance(tree, dict) else None
    return tree


def _scaled(value, factor):
    return None if value is None else value * factor


def coverage(frames):
    """Share of the frames after the start that have a pose; 0: there was no start."""
    after = frames["tracked"] + frames["lost"] + frames["dropped"]
    return frames["tracked"] / after if frames["tracked"] else 0.0


def of_run(summary):
    """{name: number or None} of one summary.json."""
    ate = _at(summary, "evaluation", "ate_rmse_m")
    failed = ate is None
    out = {
        "ate_mm": FAILED if failed else 1e3 * ate,
        "rpe_mm": FAILED if failed else _scaled(_at(summary, "evaluation", "rpe_m"), 1e3),
        "rpe_deg": FAILED if failed else _at(summary, "evaluation", "rpe_deg"),
        "coverage": coverage(summary["frames"]),
        "cpu_ms": _at(summary, "timing_ms", "end_to_end_ms", "mean"),
        "adjustments": _at(summary, "counters", "adjustments") or 0,
        "adjustments_failed": _at(summary, "counters", "adjustments_failed") or 0,
        "lost": 0 if summary["status"] == "tracked" else 1,
    }
    for part in ("position", "attitude", "velocity", "gyro_bias", "accel_bias"):
        out["nees_" + part] = _at(summary, "nees", part)
    for when in ("at_10_s", "at_end"):
        out["tilt_" + when] = _at(summary, "evaluation", f"tilt_{when}_deg")
    return out


def median(values):
    values = sorted(values)
    middle = len(values) // 2
    if len(values) % 2 or values[middle - 1] == values[middle]:
        return values[middle]
    return (values[middle - 1] + values[middle]) / 2


def figure(runs, name):
    """Median and range over runs that have it; None: no run has."""
    values = [run[name] for run in runs if run.get(name) is not None]
    if not values:
        return None
    return Figure(median(values), min(values), max(values), len(values))


def total(runs, name):
    return sum(run[name] for run in runs)


def ratio(after, before):
    """after / before of two numbers; None where that says nothing."""
    if after is None or before is None:
        return None
    if not (0 < after < FAILED and 0 < before < FAILED):
        return None
    return after / before


def verdict(after, before):
    """+1 better, -1 worse: the ranges do not touch. 0 otherwise, and of too few runs."""
    if after is None or before is None or min(after.runs, before.runs) < RUNS_OF_A_RANGE:
        return 0
    return (after.high < before.low) - (after.low > before.high)


def mean_ratio(pairs):
    """Geometric mean of (recording, ratio); rows of a recording weigh as one. None: nothing to say.

    The band takes recordings as independent: 1.96 standard errors of the mean of logarithms.
    """
    by_recording = {}
    for recording, value in pairs:
        if value is not None:
            by_recording.setdefault(recording, []).append(math.log(value))
    logs = [sum(values) / len(values) for values in by_recording.values()]
    if not logs:
        return None
    mean = sum(logs) / len(logs)
    if len(logs) == 1:
        return Ratio(math.exp(mean), None, None, 1)
    variance = sum((value - mean) ** 2 for value in logs) / (len(logs) - 1)
    band = 1.96 * math.sqrt(variance / len(logs))
    return Ratio(math.exp(mean), math.exp(mean - band), math.exp(mean + band), len(logs))


def compare(rows, after, before, name, value="median"):
    """mean_ratio over rows of one figure's median, or its high (the worst)."""
    pairs = []
    for row in rows:
        figures = [figure(results.get(row.name, []), name) for results in (after, before)]
        a, b = (getattr(f, value) if f else None for f in figures)
        pairs.append((row.recording, ratio(a, b)))
    return mean_ratio(pairs)
