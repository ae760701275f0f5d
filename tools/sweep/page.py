"""What a sweep found: a table with a row for each run, and medians over seeds, as text and page."""

import csv
import html
import math
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parent.parent
sys.path += [str(TOOLS / "lib"), str(TOOLS / "judge")]
from figures import median
from style import STYLE

FIGURES = ("frames", "coverage", "lost", "ate_mm", "rpe_mm", "rpe_deg", "nees_position",
           "nees_attitude")
OF_THE_MACHINE = ("cpu_ms", "wall_s", "host")  # two machines, or two times, do not agree on these
OWN_STYLE = """
td.runs{width:420px;padding:0 8px}td.runs svg{height:22px}.dot{fill:var(--now);fill-opacity:.55}
.middle{stroke:var(--text);stroke-width:2}.best{color:var(--good);font-weight:600}
.bad{color:var(--bad)}td:nth-child(2),th:nth-child(2){text-align:left}
"""
WIDTH, HEIGHT, EDGE = 400, 22, 6


def number(value):
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def write_table(rows, path):
    """One row a run. The last columns are of the machine; all before are the same on every one."""
    axes = list(rows[0][0].settings)
    part = path.with_suffix(".part")
    with open(part, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["recording", *axes, "seed", "error", "status", *FIGURES, *OF_THE_MACHINE])
        for job, found in rows:
            found = found or {"error": "ended before its time"}
            out.writerow([job.recording, *job.settings.values(), job.seed, found["error"],
                          *(number(found.get(name))
                            for name in ("status", *FIGURES, *OF_THE_MACHINE))])
    part.replace(path)


class Group:
    """The seeds of one recording and one choice of parameters."""

    def __init__(self, job):
        self.recording, self.settings = job.recording, job.settings
        self.results, self.missing = [], 0

    def of(self, name):
        return [found[name] for found in self.results if found.get(name) is not None]

    def middle(self, name):
        return median(self.of(name)) if self.of(name) else math.inf

    @property
    def said(self):
        return " ".join(f"{name}={value}" for name, value in self.settings.items()) or "as it is"

    @property
    def failed(self):
        """Runs without an error that can be told, or lost at the end."""
        return self.missing + sum(found["status"] != 0 or found["ate_mm"] is None
                                  for found in self.results)


def groups(rows):
    found = {}
    for job, result in rows:
        key = (job.recording, tuple(job.settings.items()))
        group = found.setdefault(key, Group(job))
        if result and not result["error"]:
            group.results.append(result)
        else:
            group.missing += 1
    return list(found.values())


def shown(value, digits):
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def best(found):
    """The best choice for each recording, by failed runs first; none where there is one choice."""
    out = []
    for name in {group.recording for group in found}:
        own = [group for group in found if group.recording == name]
        if len(own) > 1:
            out.append(min(own, key=lambda group: (group.failed, group.middle("ate_mm"))))
    return out


def text(rows):
    lines = [f"{'recording':16} {'parameters':48} runs bad   ATE mm (median, least, most)   CPU ms"]
    for group in groups(rows):
        ate = group.of("ate_mm") or [math.inf]
        lines.append(f"{group.recording:16.16} {group.said:48.48} "
                     f"{len(group.results) + group.missing:4} {group.failed:3} "
                     f"{shown(group.middle('ate_mm'), 1):>8} {shown(min(ate), 1):>8} "
                     f"{shown(max(ate), 1):>8}  {shown(group.middle('cpu_ms'), 2):>9}")
    return "\n".join(lines)


def dots(group, low, high):
    """Every seed on the recording's logarithmic scale, its median a line."""
    span = math.log(high / low) or 1.0

    def x(value):
        return EDGE + (WIDTH - 2 * EDGE) * math.log(max(value, low) / low) / span

    values = group.of("ate_mm")
    out = [f'<line class="rule" x1="0" x2="{WIDTH}" y1="{HEIGHT / 2}" y2="{HEIGHT / 2}"/>']
    out += [f'<circle class="dot" cx="{x(value):.1f}" cy="{HEIGHT / 2}" r="4">'
            f'<title>{value:.2f} mm</title></circle>' for value in values]
    if values:
        at = f"{x(median(values)):.1f}"
        out.append(f'<line class="middle" x1="{at}" x2="{at}" y1="3" y2="{HEIGHT - 3}"/>')
    return f'<svg viewBox="0 0 {WIDTH} {HEIGHT}">{"".join(out)}</svg>'


def row_of(group, low, high, is_best):
    failed = f' class="bad">{group.failed}' if group.failed else ">0"
    rest = "".join(f"<td>{shown(group.middle(name), digits)}</td>" for name, digits in
                   (("rpe_mm", 2), ("coverage", 3), ("nees_position", 2), ("cpu_ms", 2)))
    mark = ' class="best"' if is_best else ""
    return (f"<tr><td>{html.escape(group.recording)}</td><td{mark}>{html.escape(group.said)}</td>"
            f"<td>{len(group.results) + group.missing}</td><td{failed}</td>"
            f"<td{mark}>{shown(group.middle('ate_mm'), 1)}</td>"
            f'<td class="runs">{dots(group, low, high)}</td>{rest}</tr>')


def render(rows):
    found = groups(rows)
    winners, body = best(found), []
    for name in dict.fromkeys(group.recording for group in found):
        own = [group for group in found if group.recording == name]
        values = [value for group in own for value in group.of("ate_mm") if value > 0] or [1.0]
        body += [row_of(group, min(values), max(values), group in winners) for group in own]
    revisions = " ".join(sorted({result["revision"] for _, result in rows
                                 if result and not result["error"]}))
    heads = ("recording", "parameters", "runs", "failed or lost", "ATE [mm], median",
             "every run, on the recording's own logarithmic scale", "RPE over 1 s [mm]", "coverage",
             "NEES of position", "CPU per frame [ms]")
    return (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Sweep</title>'
            f"<style>{STYLE}{OWN_STYLE}</style><main><h1>Sweep</h1>"
            f'<p class="sub">{len(rows)} runs of revision {html.escape(revisions)}. Green: the '
            f"best choice of a recording, by runs that failed, then by the median over seeds. "
            f"Every run stands in sweep.csv.</p><div class='card'><table><tr>"
            + "".join(f"<th>{head}</th>" for head in heads) + f"</tr>{''.join(body)}</table></div>"
            f"</main></html>\n")
