"""Tests of the profiler's parts on small inputs.

python3 -m unittest discover -s tools/prof -p '*_test.py'
"""

import os
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bench  # noqa: E402
import elf  # noqa: E402
import estimate  # noqa: E402
import pipeline  # noqa: E402
import record  # noqa: E402
import tables  # noqa: E402
import timeline  # noqa: E402

ADD_X0_X0_1 = 0x91000400
ADD_X1_X1_1 = 0x91000421
FMUL_D0_D0_D0 = 0x1E600800
MRS_CNTVCT = 0xD53BE040

PLACES = {1: "door.frame", 2: "frontend", 3: "matching", 4: "tracking", 5: "mapping"}


def block_bytes(number, address, words):
    return (
        b"B"
        + struct.pack("<IQI", number, address, len(words))
        + struct.pack(f"<{len(words)}I", *words)
    )


def segment_bytes(cpu, place, why, mark, executions, events=()):
    return (
        b"S"
        + struct.pack("<IQBQQII", cpu, place, ord(why), mark, 0, len(executions), len(events))
        + b"".join(struct.pack("<II", *pair) for pair in list(executions) + list(events))
    )


def scope(cpu, outer, place, executions, events=()):
    """A scope that does nothing but these executions, entered from an outer place."""
    return [
        segment_bytes(cpu, outer, "b", place, []),
        segment_bytes(cpu, place, "e", place, executions, events),
    ]


def frame(cpu_right, left, right, tracking, mapping):
    """The segments of one frame: how often each task executes block 0."""
    parts = (
        scope(0, 0, 1, [(0, 1)])
        + scope(0, 0, 2, [(0, left)])
        + scope(cpu_right, 0, 2, [(0, right)])
    )
    parts += [segment_bytes(0, 0, "b", 4, [])] + scope(0, 4, 3, [(0, 2)])
    parts += [segment_bytes(0, 4, "e", 4, [(0, tracking)])]
    return parts + scope(2, 0, 5, [(0, mapping)])


class Recorded(unittest.TestCase):
    def read(self, parts):
        with tempfile.NamedTemporaryFile() as file:
            file.write(b"".join(parts))
            file.flush()
            return record.read(file.name)

    def frames(self, parts, block_cycles=10.0):
        blocks, segments = self.read([block_bytes(0, 0x1000, [ADD_X0_X0_1] * 4)] + parts)
        model = estimate.Model(blocks, ["f"], [[(block_cycles, 1.0)], [(2 * block_cycles, 1.0)]])
        pieces = estimate.pieces(segments, model, lambda place: PLACES.get(place, ""))
        return estimate.frames(pieces), pieces


class RecordTest(Recorded):
    def test_reads_what_was_written(self):
        blocks, segments = self.read(
            [
                block_bytes(0, 0x1000, [1, 2]),
                block_bytes(1, 0x2000, [3]),
                segment_bytes(3, 7, "b", 9, [(0, 5), (1, 6)], [(17, 4)]),
            ]
        )
        self.assertEqual([(b.address, b.words) for b in blocks], [(0x1000, (1, 2)), (0x2000, (3,))])
        self.assertEqual(segments[0][:4], (3, 7, "b", 9))
        self.assertEqual((segments[0].executions, segments[0].events), ((0, 5, 1, 6), (17, 4)))

    def test_refuses_a_cut_off_file(self):
        whole = block_bytes(0, 0x1000, [1, 2]) + segment_bytes(0, 0, "x", 0, [(0, 5)])
        for size in range(1, len(whole)):
            if size == len(block_bytes(0, 0x1000, [1, 2])):
                continue  # ends between two records
            with self.assertRaises(record.RecordError):
                self.read([whole[:size]])

    def test_refuses_what_is_no_record(self):
        with self.assertRaises(record.RecordError):
            self.read([b"\0"])


class EstimateTest(Recorded):
    def test_splits_by_column_frame_and_task(self):
        frames, _ = self.frames(frame(1, 5, 7, 3, 11) + frame(1, 1, 1, 1, 1) + frame(1, 9, 9, 9, 9))
        self.assertEqual(len(frames), 2)  # the last one has no end
        first = frames[0]
        cycles = {name: cost.cycles(0) for name, cost in first.column.items()}
        self.assertEqual(cycles["image"], 120)
        self.assertEqual(cycles["matching"], 20)
        self.assertEqual(cycles["tracking"], 40)  # and the frame's preparation
        self.assertEqual(cycles["mapping"], 110)
        self.assertEqual(first.end_to_end(0), 290)
        self.assertEqual(first.end_to_end(1), 580)
        self.assertEqual(first.instructions(), 4 * 29)
        self.assertEqual(first.critical(0), 10 + 70 + 20 + 30)

    def test_sides_are_told_apart_on_one_core_too(self):
        frames, _ = self.frames(frame(0, 5, 7, 3, 11) + frame(0, 1, 1, 1, 1))
        self.assertEqual(frames[0].task["frontend", 0].cycles(0), 50)
        self.assertEqual(frames[0].task["frontend", 1].cycles(0), 70)

    def test_functions_sum_to_the_total(self):
        frames, _ = self.frames(frame(1, 5, 7, 3, 11) + frame(1, 1, 1, 1, 1))
        self.assertEqual(
            sum(cost.cycles(0) for cost in frames[0].function.values()), frames[0].end_to_end(0)
        )

    def test_misses_cost_their_penalty_on_their_core(self):
        kind = record.EVENT_NAMES.index("data_l2_miss")
        parts = scope(0, 0, 1, []) + scope(
            0, 0, 2, [(0, 1)], [(kind, 3), (record.EVENTS_PER_CORE + kind, 2)]
        )
        frames, _ = self.frames(parts + scope(0, 0, 1, []))
        cost = frames[0].column["image"]
        self.assertEqual(cost.cache[0], 3 * estimate.PENALTY["cortex-a72"]["l2_miss"])
        self.assertEqual(cost.cache[1], 2 * estimate.PENALTY["cortex-a53"]["l2_miss"])

    def test_branches_predicted_wrongly_cost_on_every_core(self):
        parts = scope(0, 0, 1, []) + scope(0, 0, 2, [(0, 1)], [(record.MISPREDICTED, 3)])
        frames, _ = self.frames(parts + scope(0, 0, 1, []))
        self.assertEqual(frames[0].column["image"].branch, [45, 24])
        self.assertEqual(frames[0].column["image"].cycles(0), 10 + 45)

    def test_explains_the_worst_frame(self):
        parts = []
        for mapping in (1, 1, 100, 1, 1, 1):
            parts += frame(1, 5, 5, 5, mapping)
        frames, _ = self.frames(parts)
        worst, excess = estimate.explain_worst(frames, 0)
        self.assertEqual(worst, 2)
        self.assertEqual(excess[0], (990, 10, ("mapping", "f")))

    def test_quantiles(self):
        self.assertEqual(estimate.quantiles(range(101)), (0, 50, 99, 100))
        self.assertEqual(estimate.quantiles([4]), (4, 4, 4, 4))


class TablesTest(Recorded):
    def test_says_what_missed_and_why(self):
        parts = frame(1, 5, 7, 3, 11) + frame(1, 1, 1, 1, 1)
        frames, _ = self.frames(parts, block_cycles=3e6)
        text = tables.report(frames, "how")
        self.assertIn(
            "goal image processing           36.000 M of 22 M A72 cycles, p99 36.000 M: MISSED",
            text,
        )
        self.assertIn("because of f (36.00 M)", text)
        self.assertIn(
            "goal end to end, all cores      87.000 M of 90 M A72 cycles, p99 87.000 M: met", text
        )
        self.assertIn("What the estimate leaves out", text)


class BenchTest(Recorded):
    HEADERS = {
        "a.h": "// Cost    5 ns\n"
        "// Goal    A72 cycles: f 11 a call, g 2.5 an iteration (make bench).\nint x;\n",
        "b.h": "// Goal    A72 cycles: h 4 a pixel.\n",
    }
    SAID = (
        "boot\nbench.f call 4 units 40 cycles 44 instructions\n"
        "bench.g iteration 2 units 8 cycles 9 instructions\n"
    )

    def costs(self):
        blocks, segments = self.read(
            [block_bytes(0, 0x1000, [ADD_X0_X0_1] * 4)]
            + scope(0, 0, 8, [(0, 4)])
            + scope(0, 0, 9, [(0, 2)])
        )
        model = estimate.Model(blocks, ["f"], [[(10.0, 1.0)], [(20.0, 1.0)]])
        names = {8: "bench.f", 9: "bench.g"}
        return bench.costs(estimate.pieces(segments, model, lambda place: names.get(place, "")))

    def test_reads_goals_and_what_the_program_said(self):
        self.assertEqual(
            bench.goals(self.HEADERS),
            {"f": (11.0, "call"), "g": (2.5, "iteration"), "h": (4.0, "pixel")},
        )
        self.assertEqual(bench.printed(self.SAID)["g"], ("iteration", 2, 8, 9))

    def test_compares_per_unit(self):
        text = bench.table(self.costs(), bench.printed(self.SAID), bench.goals(self.HEADERS))
        f, g = text.splitlines()[1:]
        self.assertEqual(
            f.split(), ["f", "call", "4.00", "10.00", "11", "met", "0%", "0%", "20.00"]
        )
        self.assertEqual(g.split()[:6], ["g", "iteration", "4.00", "10.00", "2.5", "MISSED"])
        self.assertEqual(
            len(bench.table(self.costs(), bench.printed(self.SAID), {}, "g").splitlines()), 2
        )

    def test_refuses_a_goal_that_cannot_be_read_or_counts_something_else(self):
        with self.assertRaises(bench.GoalError):
            bench.goals({"a.h": "// Goal    A72 cycles: fast.\n"})
        with self.assertRaises(bench.GoalError):
            bench.table(self.costs(), bench.printed(self.SAID), {"f": (1.0, "pixel")})

    def test_every_goal_in_the_sources_can_be_read(self):
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        goals = bench.goals(bench.headers_below(os.path.join(root, "core")))
        self.assertIn("equalize", goals)
        for kernel in sorted(os.listdir(os.path.join(root, "core", "kernels"))):
            if os.path.isdir(os.path.join(root, "core", "kernels", kernel)):
                self.assertTrue(any(name.startswith(kernel) for name in goals), kernel)


class TimelineTest(Recorded):
    def test_cores_overlap_and_wait_for_each_other(self):
        _, pieces = self.frames(frame(0, 5, 7, 3, 11) + frame(0, 1, 1, 1, 1), block_cycles=1800.0)
        found = [
            (thread, name, round(begin), round(begin + length))
            for thread, name, _, begin, length, _ in timeline.events(pieces)
            if length > 0
        ]
        self.assertEqual(
            found[:3], [(0, "door.frame", 0, 1), (0, "frontend", 1, 6), (1, "frontend", 1, 8)]
        )
        self.assertEqual(found[3], (0, "matching", 8, 10))  # waits for the slower side
        self.assertEqual(found[4][:3], (0, "tracking", 10))
        self.assertEqual(found[5][:3], (2, "mapping", 13))
        self.assertEqual(found[6][:3], (0, "door.frame", 13))  # tracking never waits for mapping

    def test_events_of_one_core_do_not_overlap_by_a_nanosecond(self):
        parts = frame(0, 5, 7, 3, 11) * 40
        _, pieces = self.frames(parts, block_cycles=1234.5678)
        shown = timeline.trace_json(pieces)["traceEvents"]
        for thread in range(len(timeline.THREADS)):
            end = 0
            for event in shown:
                if event["ph"] == "X" and event["tid"] == thread:
                    begin = round(event["ts"] * 1000)
                    self.assertGreaterEqual(begin, end)
                    end = begin + round(event["dur"] * 1000)


class PipelineTest(unittest.TestCase):
    def test_disassembles_and_keeps_places_of_what_is_no_instruction(self):
        lines = pipeline.disassemble([ADD_X0_X0_1, 0xFFFFFFFF, ADD_X1_X1_1])
        self.assertEqual(
            [line and line.split() for line in lines],
            [["add", "x0,", "x0,", "#1"], None, ["add", "x1,", "x1,", "#1"]],
        )

    def test_parses_the_summary(self):
        text = (
            '{"CodeRegions": [{"Name": "4", "SummaryView": {"Iterations": 10, "TotalCycles": 55,'
            '"BlockRThroughput": 2.5}}]}'
        )
        self.assertEqual(pipeline.parse(text), {4: (5.5, 2.5)})

    def test_dependent_instructions_cost_their_latency_and_others_their_width(self):
        chain, wide, system = pipeline.cycles(
            "cortex-a72", [(FMUL_D0_D0_D0,) * 4, (ADD_X0_X0_1, ADD_X1_X1_1), (MRS_CNTVCT,)]
        )
        self.assertGreater(chain[0], 4 * 3)  # four products, each waiting for the one before
        self.assertLess(chain[1], chain[0])
        self.assertLess(wide[0], 1.5)
        self.assertGreater(system[0], 0)

    def test_a_border_of_a_page_costs_nothing(self):
        whole = (FMUL_D0_D0_D0,) * 2 + (ADD_X0_X0_1,) * 6
        with tempfile.TemporaryDirectory() as folder:
            (one,) = pipeline.placed_cycles("cortex-a72", [(0x1000, whole)], folder)
            parts = [(0x1FF8, whole[:2]), (0x2000, whole[2:])]
            a, b = pipeline.placed_cycles("cortex-a72", parts, folder)
            self.assertAlmostEqual(a[0] + b[0], one[0])
            elsewhere = [(0x1FF0, whole[:2]), (0x1FF8, whole[2:])]
            c, _ = pipeline.placed_cycles("cortex-a72", elsewhere, folder)
            self.assertGreater(c[0], a[0])

    def test_a_cache_of_results_gives_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            blocks = [(ADD_X0_X0_1,), (FMUL_D0_D0_D0,)]
            first = pipeline.cached_cycles("cortex-a53", blocks, folder)
            self.assertEqual(pipeline.cached_cycles("cortex-a53", blocks, folder), first)
            self.assertEqual([tuple(c) for c in pipeline.cycles("cortex-a53", blocks)], first)


class ElfTest(unittest.TestCase):
    def test_readable(self):
        self.assertEqual(elf.readable("pirvs::Frontend::follow()"), "Frontend::follow")
        self.assertEqual(
            elf.readable("bool pirvs::lk::align<pirvs::(anonymous namespace)::Neon>(int)"),
            "lk::align",
        )
        self.assertEqual(elf.readable("main"), "main")

    def test_finds_functions_and_names_of_places(self):
        source = """#include "core/trace/trace.h"
        pirvs::TracePlace place{"a name"};
        extern "C" void entry() { pirvs::trace_mark_begin(place); }"""
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "program")
            subprocess.run(
                [
                    "g++",
                    "-std=c++17",
                    "-O1",
                    "-no-pie",
                    "-nostdlib",
                    "-static",
                    "-Wl,-e,entry",
                    "-I",
                    root,
                    "-x",
                    "c++",
                    "-",
                    os.path.join(root, "core/trace/mark.cc"),
                    "-o",
                    path,
                ],
                input=source,
                text=True,
                check=True,
            )
            program = elf.Program(path)
            nm = subprocess.run(["nm", path], capture_output=True, text=True, check=True).stdout
            address = {line.split()[2]: int(line.split()[0], 16) for line in nm.splitlines()}
            self.assertEqual(program.place_name(address["place"]), "a name")
            mark = "_ZN5pirvs16trace_mark_beginERNS_10TracePlaceE"
            self.assertEqual(program.address_of(mark), address[mark])
            self.assertEqual(program.function_at(address[mark] + 1), "trace_mark_begin")


if __name__ == "__main__":
    unittest.main()
