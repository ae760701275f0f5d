"""Single kernels: cycles per pixel, call or iteration against the goals in their headers.

A header says `// Goal    A72 cycles: lk_extract 1500 a call, lk_align 600 an iteration.`
The program prints `bench.lk_extract call 400 units 600000 cycles 700000 instructions`.
"""

import collections
import glob
import os
import re

import record

GOAL_LINE = re.compile(r"^//\s+Goal\s+A72 cycles: (.*)$", re.M)
GOAL = re.compile(r"(\w+) ([\d.]+) an? (\w+)")
PRINTED = re.compile(r"^bench\.(\w+) (\w+) (\d+) units (\d+) cycles (\d+) instructions", re.M)
SCOPE = "bench."
A72, A53 = 0, 1

Printed = collections.namedtuple("Printed", "unit units cycles instructions")


class GoalError(Exception):
    pass


def headers_below(folder):
    """{path: text} of the headers below a folder."""
    out = {}
    for path in sorted(glob.glob(os.path.join(folder, "**", "*.h"), recursive=True)):
        with open(path, encoding="utf-8") as file:
            out[path] = file.read()
    return out


def goals(headers):
    """{kernel: (cycles, unit)} of header texts by path."""
    out = {}
    for path, text in headers.items():
        for line in GOAL_LINE.findall(text):
            found = GOAL.findall(line)
            if not found:
                raise GoalError(f"{path}: no goal can be read in: {line}")
            out.update((name, (float(cycles), unit)) for name, cycles, unit in found)
    return out


def printed(text):
    """{kernel: Printed} of what the program said."""
    return {
        name: Printed(unit, int(units), int(cycles), int(instructions))
        for name, unit, units, cycles, instructions in PRINTED.findall(text)
    }


def costs(pieces):
    """{kernel: Cost} of the scopes bench.NAME."""
    return {
        piece.place[len(SCOPE) :]: piece.cost for piece in pieces if piece.place.startswith(SCOPE)
    }


def table(all_costs, said, wanted, only=""):
    """One line per kernel, in the order of the run."""
    if not any(only in name for name in all_costs):
        raise GoalError(f"no kernel's name contains {only}; there are: {' '.join(all_costs)}")
    lines = [
        f"{'kernel':20}{'unit':>10}{'instructions':>14}{'A72 cycles':>12}{'goal':>9}{'':>8}"
        f"{'caches':>8}{'branches':>10}{'A53 cycles':>12}"
    ]
    for name, cost in all_costs.items():
        if only not in name:
            continue
        units, unit = said[name].units, said[name].unit
        cycles = cost.cycles(A72) / units
        whole = max(cost.cycles(A72), 1e-9) / 100
        verdict, goal = "none", ""
        if name in wanted:
            goal, goal_unit = wanted[name]
            if goal_unit != unit:
                raise GoalError(f"{name}: the goal is for a {goal_unit}, the bench counts {unit}s")
            verdict = "met" if cycles <= goal else "MISSED"
            goal = f"{goal:g}"
        lines.append(
            f"{name:20}{unit:>10}{cost.instructions / units:14.2f}{cycles:12.2f}"
            f"{goal:>9}{verdict:>8}"
            f"{cost.cache[A72] / whole:7.0f}%{cost.branch[A72] / whole:9.0f}%"
            f"{cost.cycles(A53) / units:12.2f}"
        )
    return "\n".join(lines)
