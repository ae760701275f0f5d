"""The profile as a timeline on the cores of an RK3399, for ui.perfetto.dev or chrome://tracing.

Pieces keep their order and wait for what they need; a core does one at a time: the left front-end,
tracking and the IMU on the first A72, the right front-end on the second, mapping on an A53 at its
own clock. A frame comes when the one before has its pose, as fast as it goes.
"""

from estimate import GHZ
from record import CORES

THREADS = ("A72 0", "A72 1", "A53 0")
A72, A53 = 0, 1


def _place(piece):
    """Thread, and the core whose cycles count."""
    if piece.place == "mapping":
        return 2, A53
    if piece.place == "frontend" and piece.order % 2 == 1:
        return 1, A72
    return 0, A72


def events(pieces):
    """(thread, name, frame, begin_us, length_us, cost) of every piece inside a scope."""
    free = [0.0] * len(THREADS)
    ready, frontends_end = 0.0, 0.0  # when the frame has begun; when both front-ends are done
    for piece in pieces:
        if piece.place == "":
            continue
        thread, core = _place(piece)
        length = piece.cost.cycles(core) / GHZ[CORES[core]] * 1e-3
        begin = free[thread]
        if piece.place == "frontend":
            begin = max(begin, ready)
        elif piece.place in ("matching", "tracking"):
            begin = max(begin, frontends_end)
        elif piece.place == "mapping":
            begin = max(begin, free[0])  # its keyframe came from tracking
        end = begin + length
        free[thread] = end
        if piece.place == "door.frame":
            ready = end
        elif piece.place == "frontend":
            frontends_end = max(frontends_end, end)
        yield thread, piece.place, piece.frame, begin, length, piece.cost


def trace_json(pieces):
    out = [
        {"ph": "M", "pid": 1, "tid": t, "name": "thread_name", "args": {"name": name}}
        for t, name in enumerate(THREADS)
    ]
    out.append(
        {
            "ph": "M",
            "pid": 1,
            "name": "process_name",
            "args": {"name": "RK3399, estimated from instruction counts"},
        }
    )
    for thread, name, frame, begin, length, cost in events(pieces):
        # Both ends to the nanosecond: a viewer drops what overlaps by one.
        ts = round(begin, 3)
        out.append(
            {
                "ph": "X",
                "pid": 1,
                "tid": thread,
                "name": name,
                "ts": ts,
                "dur": round(round(begin + length, 3) - ts, 3),
                "args": {
                    "frame": frame,
                    "instructions": cost.instructions,
                    "A72 cycles": round(cost.cycles(A72)),
                    "A53 cycles": round(cost.cycles(A53)),
                },
            }
        )
    return {"traceEvents": out, "displayTimeUnit": "ms"}
