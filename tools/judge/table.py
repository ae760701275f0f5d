"""The one-screen table."""

import math

import figures

HEAD = ("row", "ATE mm", "range", "RPE mm", "deg", "NEES p", "a", "v", "bg", "ba", "tilt 10s",
        "end", "cover", "CPU ms", "failed")
WIDTH = (12, 8, 16, 8, 7, 8, 7, 7, 7, 7, 10, 7, 8, 8, 9)


def number(value, digits):
    if value is None:
        return "-"
    return "lost" if math.isinf(value) else f"{value:.{digits}f}"


def _median(runs, name, digits):
    found = figures.figure(runs, name)
    return number(found.median if found else None, digits)


def cells(name, runs):
    ate = figures.figure(runs, "ate_mm")
    cover = figures.figure(runs, "coverage").median
    return [
        name,
        number(ate.median, 2),
        f"{number(ate.low, 2)}..{number(ate.high, 2)}",
        _median(runs, "rpe_mm", 2),
        _median(runs, "rpe_deg", 3),
        *(_median(runs, "nees_" + part, 2)
          for part in ("position", "attitude", "velocity", "gyro_bias", "accel_bias")),
        _median(runs, "tilt_at_10_s", 2),
        _median(runs, "tilt_at_end", 2),
        f"{100 * cover:.1f}%",
        _median(runs, "cpu_ms", 2),
        f"{figures.total(runs, 'adjustments_failed')}/{figures.total(runs, 'adjustments')}",
    ]


def line(words, width=WIDTH):
    return "".join(f"{word:<{w}}" if i == 0 else f"{word:>{w}}"
                   for i, (word, w) in enumerate(zip(words, width)))


MARK = {1: "better", -1: "worse", 0: ""}
COMPARED = (("ATE", "ate_mm", "median"), ("worst", "ate_mm", "high"), ("RPE t", "rpe_mm", "median"),
            ("RPE r", "rpe_deg", "median"), ("CPU", "cpu_ms", "median"))


def change(found):
    if found is None:
        return "-"
    if found.low is None:
        return f"x{found.change:.3f}"
    return f"x{found.change:.3f} ({found.low:.2f}..{found.high:.2f})"


def groups(rows):
    """(title, rows) to be averaged: what decides, what confirms, then each kind."""
    out = [(part, [row for row in rows if row.part == part]) for part in ("decide", "confirm")]
    for kind in dict.fromkeys(row.kind for row in rows):
        out.append((kind, [row for row in rows if row.kind == kind]))
    return [(title, members) for title, members in out if members]


def text(rows, after, before=None):
    head = list(HEAD) + (["before", ""] if before else [])
    width = list(WIDTH) + [9, 8]
    lines = [line(head, width)]
    for row in rows:
        words = cells(row.name, after[row.name])
        if before and row.name in before:
            now, then = (figures.figure(runs[row.name], "ate_mm") for runs in (after, before))
            words += [number(then.median, 2), MARK[figures.verdict(now, then)]]
        lines.append(line(words, width))
    if before:
        lines += ["", "after / before, geometric mean of medians (95 % band over recordings)"]
        lines.append(line(["", *(title for title, _, _ in COMPARED)], (12, 22, 22, 22, 22, 22)))
        for title, members in groups(rows):
            found = [figures.compare(members, after, before, *what) for _, *what in COMPARED]
            lines.append(line([title, *map(change, found)], (12, 22, 22, 22, 22, 22)))
    return "\n".join(lines)
