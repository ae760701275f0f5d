"""The page: the table, and how well confidence tells wrong frames from good ones."""

import html
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "lib"))
from style import STYLE

OWN_STYLE = """
th:nth-child(2),td:nth-child(2),td:last-child,th:last-child{text-align:left}
.good{color:var(--good)}.bad{color:var(--bad)}svg{max-width:620px}svg text{fill:var(--soft)}
.dot{fill:var(--now)}.curve{fill:none;stroke:var(--now);stroke-width:2}
.curve.second{stroke:var(--soft)}
"""
WIDTH, HEIGHT, LEFT, TOP = 520, 300, 46, 12
DOUBTED_MAX = 0.2  # of the good frames: what lies beyond is of no use


def plot(curves):
    """Of {which frames are good: curve}; thresholds stand at the first."""
    def x(doubted):
        return LEFT + (WIDTH - LEFT) * min(1.0, doubted / DOUBTED_MAX)

    def y(caught):
        return TOP + (HEIGHT - TOP) * (1 - caught)

    out = [f'<svg viewBox="0 0 {WIDTH + 60} {HEIGHT + 44 + 18 * len(curves)}">']
    for k in range(5):
        share = k / 4
        out.append(f'<line class="rule" x1="{LEFT}" x2="{WIDTH}" y1="{y(share)}" y2="{y(share)}"/>'
                   f'<text x="{LEFT - 6}" y="{y(share) + 4}" text-anchor="end">{share:.0%}</text>'
                   f'<text x="{x(share * DOUBTED_MAX)}" y="{HEIGHT + 16}" text-anchor="middle">'
                   f'{share * DOUBTED_MAX:.0%}</text>')
    out.append(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT + 34}" text-anchor="middle">good frames '
               f'doubted</text>')
    for k, (which, curve) in enumerate(curves.items()):
        style = "curve second" if k else "curve"
        points = " ".join(f"{x(d):.1f},{y(c):.1f}" for _, d, c in curve)
        at = HEIGHT + 52 + 18 * k
        out.append(f'<polyline class="{style}" points="{points}"/>'
                   f'<line class="{style}" x1="{LEFT}" x2="{LEFT + 24}" y1="{at - 4}" '
                   f'y2="{at - 4}"/><text x="{LEFT + 32}" y="{at}">{which}</text>')
    for threshold, doubted, caught in next(iter(curves.values())):
        if doubted <= DOUBTED_MAX and round(threshold * 100) in (20, 100):
            out.append(f'<circle class="dot" cx="{x(doubted):.1f}" cy="{y(caught):.1f}" r="3"/>'
                       f'<text x="{x(doubted) + 8:.1f}" y="{y(caught) + 14:.1f}">'
                       f'{threshold:.1f}</text>')
    out.append("</svg>")
    return "".join(out)


def row_of(case, status, verdict, good, said):
    mark = '<td class="good">yes</td>' if good else '<td class="bad">no</td>'
    cells = ["no pose", "", "", "", ""] if verdict is None else [
        f"{verdict.error_end:.3f}", f"{verdict.error_max:.3f}", f"{verdict.sigma_end:.3f}",
        f"{verdict.confidence:.2f} ({verdict.confidence_min:.2f})", f"{100 * verdict.lies:.1f} %"]
    told = " ".join(verdict.reasons) if verdict else said
    return (f"<tr><td>{case.kind}</td><td>{html.escape(case.name)}</td>{mark}<td>{status}</td>"
            + "".join(f"<td>{cell}</td>" for cell in cells)
            + f"<td>{html.escape(told[:110])}</td></tr>")


def render(rows, curves):
    heads = ("kind", "case", "honest", "status", "error at the end [m]", "at most", "sigma",
             "confidence (least)", "lies", "told")
    return (f'<!doctype html><meta charset="utf-8"><title>Trust</title>'
            f'<style>{STYLE}{OWN_STYLE}</style>'
            f"<main><h1>Trust</h1><p class='sub'>A lie: confidence above 0.6 and an error above "
            f"0.15 m and three of the sigmas given out.</p><div class='card'><table><tr>"
            + "".join(f"<th>{head}</th>" for head in heads) + "</tr>"
            + "".join(row_of(*row) for row in rows)
            + "</table></div><h2>Wrong frames caught against good frames doubted, by threshold of "
              f"confidence</h2><div class='card'>{plot(curves)}</div></main>\n")
