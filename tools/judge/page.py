"""The page: what table.py prints, drawn. Needs nothing but itself."""

import html
import math
import sys
from pathlib import Path

import figures
import table

sys.path.append(str(Path(__file__).resolve().parent.parent / "lib"))
from style import STYLE

LEFT, WIDTH, ROW, TOP = 120, 620, 22, 24
# title, figure, digits; drawn on a logarithmic scale but where a value may be zero
PLOTS = (("ATE [mm]", "ate_mm", 1, True), ("RPE over 1 s [mm]", "rpe_mm", 1, True),
         ("RPE over 1 s [deg]", "rpe_deg", 3, True), ("NEES of position", "nees_position", 2, True),
         ("NEES of attitude", "nees_attitude", 2, True),
         ("NEES of velocity", "nees_velocity", 2, True),
         ("NEES of the gyro's bias", "nees_gyro_bias", 2, True),
         ("NEES of the accelerometer's bias", "nees_accel_bias", 2, True),
         ("Tilt 10 s after the start [deg]", "tilt_at_10_s", 3, False),
         ("Tilt at the end [deg]", "tilt_at_end", 3, False),
         ("Coverage after the start", "coverage", 3, False),
         ("CPU per stereo frame [ms]", "cpu_ms", 2, False))
NEES_HONEST = 3
LESS_IS_BETTER = ("ate_mm", "rpe_mm", "rpe_deg", "tilt_at_10_s", "tilt_at_end", "cpu_ms")


def scale_of(values, logarithmic):
    """A function from a value to px, for values above zero."""
    finite = [v for v in values if math.isfinite(v) and (v > 0 or not logarithmic)]
    if not finite:
        return lambda value: LEFT
    if logarithmic:
        low, high = math.log(min(finite)) - 0.2, math.log(max(finite)) + 0.05
    else:
        low, high = 0.0, max(max(finite) * 1.02, 1e-9)

    def px(value):
        if math.isinf(value):
            return WIDTH
        at = math.log(max(value, 1e-12)) if logarithmic else value
        return LEFT + (WIDTH - LEFT) * min(1.0, max(0.0, (at - low) / (high - low)))

    return px


def bar(found, px, y, height, style):
    if found is None:
        return ""
    middle = y + height / 2
    return (f"<rect class={style} x={LEFT} y={y:.1f} width={px(found.median) - LEFT:.1f} "
            f"height={height:.1f} rx=2 />"
            f"<line class=range x1={px(found.low):.1f} x2={px(found.high):.1f} y1={middle:.1f} "
            f"y2={middle:.1f} />")


def bars(rows, after, before, plot):
    """Median and range of each row; the one before below it."""
    title, name, digits, logarithmic = plot
    shown = []
    for row in rows:
        now = figures.figure(after[row.name], name)
        then = figures.figure(before.get(row.name, []), name) if before else None
        if now:
            shown.append((row.name, now, then))
    if not shown:
        return ""
    values = [v for _, now, then in shown for f in (now, then) if f for v in (f.low, f.high)]
    px = scale_of(values, logarithmic)
    out = [f"<svg viewBox='0 0 {WIDTH + 70} {TOP + ROW * len(shown) + 6}'>",
           f"<text x=0 y=14 font-weight=600>{html.escape(title)}</text>"]
    if name.startswith("nees"):
        out.append(f"<line class=range stroke-dasharray='3 3' x1={px(NEES_HONEST):.1f} "
                   f"x2={px(NEES_HONEST):.1f} y1={TOP - 4} y2={TOP + ROW * len(shown)} />")
    for index, (label, now, then) in enumerate(shown):
        y = TOP + ROW * index
        mark = table.MARK[figures.verdict(now, then)] if name in LESS_IS_BETTER else ""
        out.append(f"<line class=rule x1=0 x2={WIDTH + 70} y1={y + ROW - 2} y2={y + ROW - 2} />"
                   f"<text x=0 y={y + 14}>{html.escape(label)}</text>")
        out.append(bar(now, px, y + 2, 9 if then else 14, "now") + bar(then, px, y + 12, 6, "then"))
        out.append(f"<text x={WIDTH + 66} y={y + 14} text-anchor=end>"
                   f"<tspan class='{mark}' fill='currentColor'>"
                   f"{table.number(now.median, digits)}</tspan></text>")
    return "<div class=card>" + "".join(out) + "</svg></div>"


def html_table(head, lines):
    out = ["<div class=card><table><tr>", *(f"<th>{html.escape(h)}</th>" for h in head), "</tr>"]
    for words in lines:
        out.append("<tr>" + "".join(f"<td class='{word if word in table.MARK.values() else ''}'>"
                                    f"{word if word.startswith('<a ') else html.escape(word)}</td>"
                                    for word in words) + "</tr>")
    return "".join(out) + "</table></div>"


def worst_run(runs):
    return max(range(len(runs)), key=lambda index: runs[index]["ate_mm"])


def main_table(rows, after, before):
    head, lines = table.body(rows, after, before)
    for row, words in zip(rows, lines):
        report = f"runs/{row.name}/{worst_run(after[row.name])}/report.html"
        words[0] = f"<a href='{html.escape(report)}'>{html.escape(row.name)}</a>"
    return html_table(head, lines)


def page(rows, after, before, about):
    body = ["<h1>A set to judge by</h1>", f"<p class=sub>{html.escape(about)}</p>"]
    if before:
        body += ["<h2>After / before</h2><p class=sub>Geometric mean of the ratios of medians, and "
                 "its 95 % band over recordings. Below 1 is better. `decide` judges; `confirm` "
                 "holds seeds that nobody tuned with.</p>",
                 html_table(*table.compared(rows, after, before))]
    body += ["<h2>Every row</h2><p class=sub>Medians of runs whose starts lie a frame apart. A "
             "name leads to the report of the run with the largest ATE. NEES is 3 where the "
             "covariance is honest.</p>", main_table(rows, after, before)]
    if any(row.part == "mode" for row in rows):
        body += ["<h2>Ways to run</h2>", html_table(*table.modes(rows, after))]
    plain = [row for row in rows if row.part != "mode"]
    body += ["<h2>Drawn</h2><p class=sub>Bar: median; line: range"
             + ("; grey: before" if before else "") + ". Errors and NEES on a logarithmic scale."
             "</p><div class=grid>",
             *(bars(plain, after, before, plot) for plot in PLOTS), "</div>"]
    return ("<!doctype html><meta charset=utf-8><title>A set to judge by</title>"
            f"<style>{STYLE}</style><main>{''.join(body)}</main>\n")
