"""The tables: every row, ways to run, after against before. As text for one screen."""

import math

import figures

HEAD = ("row", "ATE mm", "range", "RPE mm", "deg", "NEES p", "a", "v", "bg", "ba", "tilt 10s",
        "end", "cover", "CPU ms", "failed")
WIDTH = (18, 8, 16, 8, 7, 8, 7, 7, 7, 7, 10, 7, 8, 8, 9)
WIDTH_BEFORE = (9, 8)
WIDTH_RATIO = (18, 22, 22, 22, 22, 22)
MARK = {1: "better", -1: "worse", 0: ""}
COMPARED = (("ATE", "ate_mm", "median"), ("worst ATE", "ate_mm", "high"),
            ("RPE mm", "rpe_mm", "median"), ("RPE deg", "rpe_deg", "median"),
            ("CPU", "cpu_ms", "median"))


def number(value, digits):
    if value is None:
        return "-"
    return "lost" if math.isinf(value) else f"{value:.{digits}f}"


def _median(runs, name, digits):
    found = figures.figure(runs, name)
    return number(found.median if found else None, digits)


def _cells(name, runs):
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


def body(rows, after, before=None):
    """(head, a line of words for each row); with before its ATE and whether the ranges part."""
    lines = []
    for row in rows:
        words = _cells(row.name, after[row.name])
        if before:
            then = figures.figure(before.get(row.name, []), "ate_mm")
            now = figures.figure(after[row.name], "ate_mm")
            words += [number(then.median if then else None, 2), MARK[figures.verdict(now, then)]]
        lines.append(words)
    return [*HEAD, *(("before", "") if before else ())], lines


def change(found):
    if found is None:
        return "-"
    if found.low is None:
        return f"x{found.change:.3f}"
    return f"x{found.change:.3f} ({found.low:.2f}..{found.high:.2f})"


def _groups(rows):
    """(title, rows) to be averaged: what decides, what confirms, then each kind."""
    out = [(part, [row for row in rows if row.part == part]) for part in ("decide", "confirm")]
    for kind in dict.fromkeys(row.kind for row in rows if row.part != "mode"):
        out.append((kind, [row for row in rows if row.kind == kind]))
    return [(title, members) for title, members in out if members]


def compared(rows, after, before):
    """(head, a line for each group): geometric means of after / before."""
    lines = []
    for title, members in _groups(rows):
        found = [figures.compare(members, after, before, *what) for _, *what in COMPARED]
        lines.append([title, *map(change, found)])
    return ["", *(title for title, _, _ in COMPARED)], lines


def _plain(row, rows):
    """The row that runs the same recording in no other way, from the same start."""
    for other in rows:
        if (other.recording, other.start_s, other.options) == (row.recording, row.start_s, []):
            return other
    return None


def modes(rows, after):
    """(head, a line for each other way to run): ratio to the plain way, and whether it is that."""
    lines = []
    for kind in dict.fromkeys(row.kind for row in rows if row.part == "mode"):
        pairs, same = {"ate_mm": [], "rpe_mm": []}, []
        for row in rows:
            plain = _plain(row, rows)
            if row.kind != kind or plain is None:
                continue
            runs = after[row.name]
            plain_runs = after[plain.name][:len(runs)]
            same += [a["ate_mm"] == b["ate_mm"] for a, b in zip(runs, plain_runs)]
            for name, found in pairs.items():
                medians = [figures.figure(r, name).median for r in (runs, plain_runs)]
                found.append((row.recording, figures.ratio(*medians)))
        lines.append([kind, *(change(figures.mean_ratio(found)) for found in pairs.values()),
                      f"{sum(same)} of {len(same)}"])
    return ["against plain", "ATE", "RPE mm", "same ATE"], lines


def _line(words, width):
    return "".join(f"{word:<{w}}" if i == 0 else f"{word:>{w}}"
                   for i, (word, w) in enumerate(zip(words, width)))


def _text(head, lines, width):
    return [_line(words, width).rstrip() for words in (head, *lines)]


def text(rows, after, before=None):
    out = _text(*body(rows, after, before), WIDTH + WIDTH_BEFORE)
    if any(row.part == "mode" for row in rows):
        out += ["", *_text(*modes(rows, after), WIDTH_RATIO)]
    if before:
        out += ["", "after / before: geometric mean of medians, 95 % band over recordings",
                *_text(*compared(rows, after, before), WIDTH_RATIO)]
    return "\n".join(out)
