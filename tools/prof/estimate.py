"""From counts to estimated time: per column of the paper's Table II, function and frame."""

import collections

import record

# Cycles that a miss adds. In sequence: a hardware prefetcher asked for the line before, so that the
# core waits for bandwidth instead of latency. Random misses count in full, though a core that
# executes out of order hides part of them.
#   L2 hit: 14 and 13 cycles more than an L1 hit.
#   memory: 120 ns on LPDDR3/4, in sequence 64 bytes at 7 and 3.5 GB/s.
PENALTY = {
    "cortex-a72": {
        "l1_miss": 14,
        "l1_miss_in_sequence": 2,
        "l2_miss": 216,
        "l2_miss_in_sequence": 16,
    },
    "cortex-a53": {
        "l1_miss": 13,
        "l1_miss_in_sequence": 3,
        "l2_miss": 168,
        "l2_miss_in_sequence": 26,
    },
}
# A branch that was predicted wrongly: the pipeline is filled anew.
MISPREDICTED_PENALTY = {"cortex-a72": 15, "cortex-a53": 8}
GHZ = {"cortex-a72": 1.8, "cortex-a53": 1.4}

COLUMNS = ("image", "matching", "tracking", "mapping")
COLUMN_OF_PLACE = {
    "frontend": "image",
    "matching": "matching",
    "tracking": "tracking",
    "door.frame": "tracking",
    "imu": "tracking",
    "mapping": "mapping",
}
OUTSIDE = "outside"  # the schedule, waiting, output
FRAME_BEGINS = "door.frame"


class Cost:
    """Instructions, and per core: cycles in the pipeline, waiting for caches, after branches that
    were predicted wrongly."""

    __slots__ = ("instructions", "pipeline", "cache", "branch")

    def __init__(self):
        self.instructions = 0
        self.pipeline = [0.0] * len(record.CORES)
        self.cache = [0.0] * len(record.CORES)
        self.branch = [0.0] * len(record.CORES)

    def add(self, other):
        self.instructions += other.instructions
        for c in range(len(record.CORES)):
            self.pipeline[c] += other.pipeline[c]
            self.cache[c] += other.cache[c]
            self.branch[c] += other.branch[c]

    def cycles(self, core):
        return self.pipeline[core] + self.cache[core] + self.branch[core]


# One run of a scope between marks. order: which of that place's scopes in its frame, from 0.
Piece = collections.namedtuple("Piece", "cpu place frame order cost functions")


class Model:
    """What one block costs."""

    def __init__(self, blocks, functions, cycles):
        """functions: name per block. cycles: per core, (cycles, bound) per block."""
        self.sizes = [len(block.words) for block in blocks]
        self.functions = functions
        self.cycles = cycles
        self.penalties = []
        for core in record.CORES:
            names = [name.split("_", 1)[1] for name in record.EVENT_NAMES]
            self.penalties += [PENALTY[core][name] for name in names]

    def piece_cost(self, segment):
        """Cost of a segment per function."""
        out = collections.defaultdict(Cost)
        pairs = iter(segment.executions)
        for block, count in zip(pairs, pairs):
            cost = out[self.functions[block]]
            cost.instructions += count * self.sizes[block]
            for c, cycles in enumerate(self.cycles):
                cost.pipeline[c] += count * cycles[block][0]
        pairs = iter(segment.events)
        for key, count in zip(pairs, pairs):
            block, kind = divmod(key, record.EVENTS_PER_BLOCK)
            cost = out[self.functions[block]]
            if kind == record.MISPREDICTED:
                for c, core in enumerate(record.CORES):
                    cost.branch[c] += count * MISPREDICTED_PENALTY[core]
            else:
                cost.cache[kind // record.EVENTS_PER_CORE] += count * self.penalties[kind]
        return out


def pieces(segments, model, place_name):
    """Costs per scope. A scope that an inner one interrupts comes back as several pieces of one
    order. Work on any CPU belongs to the latest frame that had begun by then."""
    out, frame = [], 0
    seen = collections.Counter()  # scopes of a place begun in this frame
    order_of = collections.defaultdict(list)  # per CPU: order of each scope on its stack
    for segment in segments:
        name = place_name(segment.place)
        functions = model.piece_cost(segment)
        cost = Cost()
        for part in functions.values():
            cost.add(part)
        orders = order_of[segment.cpu]
        out.append(Piece(segment.cpu, name, frame, orders[-1] if orders else 0, cost, functions))
        if segment.why == "b":
            begins = place_name(segment.mark)
            if begins == FRAME_BEGINS:
                frame += 1
                seen.clear()
            orders.append(seen[begins])
            seen[begins] += 1
        elif segment.why == "e" and orders:
            orders.pop()
    return out


class Frame:
    """Costs of one frame, by column and function."""

    def __init__(self):
        self.column = collections.defaultdict(Cost)
        self.function = collections.defaultdict(Cost)  # key: column, function
        self.task = collections.defaultdict(Cost)  # key: place, order (0 left, 1 right)

    def end_to_end(self, core):
        return sum(self.column[column].cycles(core) for column in COLUMNS)

    def instructions(self):
        return sum(self.column[column].instructions for column in COLUMNS)

    def critical(self, core):
        """From the frame's arrival to its pose, with one core for each camera."""
        before = self.task["door.frame", 0].cycles(core)
        sides = [cost.cycles(core) for (place, _), cost in self.task.items() if place == "frontend"]
        after = self.task["matching", 0].cycles(core) + self.task["tracking", 0].cycles(core)
        return before + max(sides, default=0.0) + after


def frames(all_pieces):
    """One Frame per camera frame. What ran before the first is left out, and so is the last one,
    since nothing marks where its work ends."""
    out = collections.defaultdict(Frame)
    for piece in all_pieces:
        if piece.frame == 0:
            continue
        frame = out[piece.frame]
        column = COLUMN_OF_PLACE.get(piece.place, OUTSIDE)
        frame.column[column].add(piece.cost)
        order = (
            piece.order if piece.place in ("frontend", "matching", "tracking", "door.frame") else 0
        )
        frame.task[piece.place, order].add(piece.cost)
        for name, cost in piece.functions.items():
            frame.function[column, name].add(cost)
    return [out[number] for number in sorted(out)[:-1]]


def quantiles(values):
    """min, median, p99, max."""
    ordered = sorted(values)
    at = lambda share: ordered[min(len(ordered) - 1, int(share * len(ordered)))]
    return ordered[0], at(0.5), at(0.99), ordered[-1]


def per_function(all_frames):
    """{(column, function): Cost summed over all frames}."""
    out = collections.defaultdict(Cost)
    for frame in all_frames:
        for key, cost in frame.function.items():
            out[key].add(cost)
    return out


def explain_worst(all_frames, core):
    """Index of the costliest frame; how far each function exceeds its median, largest first."""
    worst = max(range(len(all_frames)), key=lambda i: all_frames[i].end_to_end(core))
    keys = {key for key in all_frames[worst].function if key[0] != OUTSIDE}
    excess = []
    for key in keys:
        median = quantiles(
            [
                frame.function[key].cycles(core) if key in frame.function else 0.0
                for frame in all_frames
            ]
        )[1]
        excess.append((all_frames[worst].function[key].cycles(core) - median, median, key))
    excess.sort(reverse=True)
    return worst, excess
