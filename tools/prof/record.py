"""Reads what plugin.c wrote: blocks of instructions, and segments between marks.

A segment is what one CPU did from one mark of core/trace to the next: how often it executed each
block, and which of the memory accesses missed in the modelled caches.
"""

import collections
import struct

# Order of plugin.c: core, then fetch or data, then what the access found.
CORES = ("cortex-a72", "cortex-a53")
EVENTS_PER_CORE = 8
MISPREDICTED = EVENTS_PER_CORE * len(CORES)  # the same for all cores
EVENTS_PER_BLOCK = MISPREDICTED + 1
EVENT_NAMES = (
    "fetch_l1_miss",
    "fetch_l1_miss_in_sequence",
    "fetch_l2_miss",
    "fetch_l2_miss_in_sequence",
    "data_l1_miss",
    "data_l1_miss_in_sequence",
    "data_l2_miss",
    "data_l2_miss_in_sequence",
)

Block = collections.namedtuple("Block", "address words")
Segment = collections.namedtuple(
    "Segment", "cpu place why mark instructions_before executions events"
)  # both flat: key, count, key ...

_BLOCK = struct.Struct("<IQI")
_SEGMENT = struct.Struct("<IQBQQII")


class RecordError(Exception):
    pass


def read(path):
    """Returns the list of blocks, by id, and that of segments in the order in which they ended."""
    with open(path, "rb") as file:
        data = memoryview(file.read())
    blocks, segments = [], []
    at = 0
    try:
        while at < len(data):
            kind = data[at]
            at += 1
            if kind == ord("B"):
                number, address, count = _BLOCK.unpack_from(data, at)
                at += _BLOCK.size
                if number != len(blocks):
                    raise RecordError(f"{path}: block {number} where {len(blocks)} was expected")
                blocks.append(Block(address, struct.unpack_from(f"<{count}I", data, at)))
                at += 4 * count
            elif kind == ord("S"):
                cpu, place, why, mark, before, executions, events = _SEGMENT.unpack_from(data, at)
                at += _SEGMENT.size
                pairs = [struct.unpack_from(f"<{2 * executions}I", data, at)]
                at += 8 * executions
                pairs.append(struct.unpack_from(f"<{2 * events}I", data, at))
                at += 8 * events
                segments.append(Segment(cpu, place, chr(why), mark, before, *pairs))
            else:
                raise RecordError(f"{path}: no record begins with {kind} at byte {at - 1}")
    except struct.error:
        raise RecordError(f"{path}: cut off") from None
    return blocks, segments
