"""The profile as text."""

import estimate
from estimate import COLUMNS, GHZ, OUTSIDE
from record import CORES

LABEL = {
    "image": "Image Processing",
    "matching": "Matching",
    "tracking": "Tracking",
    "mapping": "Mapping",
}
TASKS = (
    ("front-end, left", ("frontend", 0)),
    ("front-end, right", ("frontend", 1)),
    ("prepare a frame", ("door.frame", 0)),
    ("IMU", ("imu", 0)),
    ("matching", ("matching", 0)),
    ("tracking", ("tracking", 0)),
    ("mapping", ("mapping", 0)),
)
# The paper's Table II, "PIRVS on PIRVS hardware": two A72, four A53.
PAPER_MS = {"image": 30, "matching": 3.8, "tracking": 8.5, "mapping": 57.2}
PAPER_END_TO_END_MS = 99.5
FUNCTIONS_SHOWN = 30
EXCESS_SHOWN = 8
A72, A53 = 0, 1

# Goals on estimated A72 cycles of a 752 x 480 stereo frame, mean over the frames.
GOALS = (
    ("image processing", 22e6, lambda frame: frame.column["image"].cycles(A72), ("image",)),
    ("end to end, all cores", 90e6, lambda frame: frame.end_to_end(A72), COLUMNS),
    (
        "critical path, two A72",
        30e6,
        lambda frame: frame.critical(A72),
        ("image", "matching", "tracking"),
    ),
)

LEFT_OUT = """What the estimate leaves out: misses of the TLB, stores that a later load reads,
prefetchers other than for lines in sequence, contention for L2 and memory between cores and with
the cameras' DMA, the bandwidth of a memory that others use, interrupts of a real sensor, clocks
below 1.8 / 1.4 GHz when hot. Caches and branch prediction are models of usual size, not the
chip's own. Pessimistic: random misses do not overlap, and a straight-line block depends on its
last run. Instructions are counted exactly."""


def ms(cycles, core):
    return cycles / GHZ[CORES[core]] * 1e-6


def mean(values):
    return sum(values) / len(values)


def stage_table(frames):
    """The paper's Table II: mean per stereo frame."""
    lines = [
        f"{'mean per stereo frame':24}{'instructions':>14}{'A72 cycles':>13}{'ms at 1.8 GHz':>15}"
        f"{'A53 cycles':>13}{'ms at 1.4 GHz':>15}{'caches':>8}{'branches':>10}{'paper, ms':>11}"
    ]

    def row(label, columns, paper_ms=""):
        instructions = mean([sum(f.column[c].instructions for c in columns) for f in frames])
        cycles = [
            mean([sum(f.column[c].cycles(core) for c in columns) for f in frames])
            for core in (A72, A53)
        ]
        caches = mean([sum(f.column[c].cache[A72] for c in columns) for f in frames])
        branches = mean([sum(f.column[c].branch[A72] for c in columns) for f in frames])
        whole = max(cycles[A72], 1) / 100
        lines.append(
            f"{label:24}{instructions / 1e6:12.3f} M{cycles[A72] / 1e6:11.3f} M"
            f"{ms(cycles[A72], A72):15.3f}{cycles[A53] / 1e6:11.3f} M"
            f"{ms(cycles[A53], A53):15.3f}{caches / whole:7.0f}%{branches / whole:9.0f}%"
            f"{paper_ms:>11}"
        )

    for column in COLUMNS:
        row(LABEL[column], (column,), PAPER_MS[column])
    row("End-to-End", COLUMNS, PAPER_END_TO_END_MS)
    row("(outside the stages)", (OUTSIDE,))
    return lines


def spread_table(frames):
    """Per frame: min, median, p99, max."""
    lines = [
        f"{'A72 cycles a frame [M]':24}{'min':>10}{'median':>10}{'p99':>10}{'max':>10}"
        f"   {'A53 [M]':>8}{'median':>10}{'p99':>10}{'max':>10}"
    ]

    def row(label, of):
        a72 = estimate.quantiles([of(f, A72) / 1e6 for f in frames])
        a53 = estimate.quantiles([of(f, A53) / 1e6 for f in frames])
        lines.append(
            f"{label:24}"
            + "".join(f"{v:10.3f}" for v in a72)
            + " " * 11
            + "".join(f"{v:10.3f}" for v in a53[1:])
        )

    for column in COLUMNS:
        row(LABEL[column], lambda f, core, c=column: f.column[c].cycles(core))
    row("End-to-End", lambda f, core: f.end_to_end(core))
    for label, key in TASKS:
        row("  task " + label, lambda f, core, k=key: f.task[k].cycles(core) if k in f.task else 0)
    row("critical path", lambda f, core: f.critical(core))
    return lines


def function_table(frames):
    """What each function costs, mean per frame."""
    n = len(frames)
    total = sum(f.end_to_end(A72) for f in frames)
    costs = [item for item in estimate.per_function(frames).items() if item[0][0] != OUTSIDE]
    costs.sort(key=lambda item: -item[1].cycles(A72))
    lines = [
        f"{'function':44}{'stage':>10}{'instr. [k]':>12}{'A72 [k]':>11}{'share':>7}{'IPC':>6}"
        f"{'caches':>8}{'branches':>10}{'A53 [k]':>11}"
    ]
    for (column, name), cost in costs[:FUNCTIONS_SHOWN]:
        cycles = cost.cycles(A72)
        lines.append(
            f"{name[:43]:44}{column:>10}{cost.instructions / n / 1e3:12.1f}"
            f"{cycles / n / 1e3:11.1f}{100 * cycles / total:6.1f}%"
            f"{cost.instructions / cycles:6.2f}{100 * cost.cache[A72] / cycles:7.0f}%"
            f"{100 * cost.branch[A72] / cycles:9.0f}%"
            f"{cost.cycles(A53) / n / 1e3:11.1f}"
        )
    return lines


def worst_frame(frames):
    worst, excess = estimate.explain_worst(frames, A72)
    cost = frames[worst].end_to_end(A72) / 1e6
    median = estimate.quantiles([f.end_to_end(A72) / 1e6 for f in frames])[1]
    lines = [
        f"worst frame: number {worst + 1}, {cost:.3f} M A72 cycles, {cost - median:.3f} M above "
        "the median. Functions"
        " that made it so, above their own median:"
    ]
    for more, usual, (column, name) in excess[:EXCESS_SHOWN]:
        if more > 0:
            lines.append(
                f"  {name[:43]:44}{column:>10}{more / 1e6:10.3f} M above {usual / 1e6:.3f} M"
            )
    return lines


def goals(frames):
    """Met or missed; where missed, the functions that cost it."""
    lines = []
    costs = estimate.per_function(frames)
    for label, goal, of, columns in GOALS:
        value = mean([of(f) for f in frames])
        p99 = estimate.quantiles([of(f) for f in frames])[2]
        lines.append(
            f"goal {label:24}{value / 1e6:9.3f} M of {goal / 1e6:.0f} M A72 cycles, "
            f"p99 {p99 / 1e6:.3f} M: "
            + ("met" if value <= goal else "MISSED")
        )
        if value > goal:
            guilty = sorted(
                (item for item in costs.items() if item[0][0] in columns),
                key=lambda item: -item[1].cycles(A72),
            )[:3]
            lines.append(
                "     because of "
                + ", ".join(
                    f"{name} ({cost.cycles(A72) / len(frames) / 1e6:.2f} M)"
                    for (_, name), cost in guilty
                )
            )
    mapping = [f.column["mapping"].cycles(A53) for f in frames]
    lines.append(
        f"beside it, mapping on an A53: {ms(mean(mapping), A53):.2f} ms a frame in the mean, "
        f"{ms(max(mapping), A53):.2f} ms in the worst"
    )
    return lines


def bound_line(bound, pipeline):
    return (
        f"Pipeline: of {pipeline / 1e6:.1f} M A72 cycles in all, {bound / 1e6:.1f} M are the least "
        "that "
        "the execution units allow; the rest waits for results."
    )


def report(frames, how):
    parts = [
        how,
        stage_table(frames),
        spread_table(frames),
        function_table(frames),
        worst_frame(frames),
        goals(frames),
        LEFT_OUT,
    ]
    return "\n\n".join(part if isinstance(part, str) else "\n".join(part) for part in parts)
