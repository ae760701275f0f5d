"""Situations in which such systems were confidently wrong, by kind, each made of a clean recording.

A case is (name, kind, base, spoil, words for `pirvs run`). spoil(recording) changes a Recording.
`must_fail`: the run has to end with exit status 1.
"""

import collections
import math

from recording import NS, motors

Case = collections.namedtuple("Case", "name kind base spoil words must_fail fault_s",
                              defaults=(None, (), False, None))

# Options of `pirvs sim`. None: the recording is given, the real clip.
BASES = {
    "clip": None,
    "flight": "--rate 200 --duration 14 --format pgm --blur 1 --seed 5 --rest 1.5",
    "rest": "--path rest --duration 30 --format pgm --seed 3",
    "car": "--path steady --forward 1.0 --left 0 --rest 0 --ramp 0.01 --duration 15 --format pgm",
    "dim": "--duration 14 --format pgm --blur 1 --seed 7 --noise 6 --dark 0.96 --dark-from 6 "
           "--dark-for 5",
    "chequered": "--duration 14 --format pgm --blur 1 --seed 5 --surfaces chequered",
    "chequered walls": "--duration 14 --format pgm --blur 1 --seed 6 --boxes 0 "
                       "--surfaces chequered",
    "plain": "--duration 14 --format pgm --blur 1 --seed 5 --surfaces plain",
    "plain walls": "--duration 14 --format pgm --blur 1 --seed 6 --surfaces plain --boxes 0",
}
FAULT_S = 10  # of what begins in the middle of a rest


def every(step, late=0):
    """Of images at 200 Hz each step-th; the right camera's are so many later."""
    def spoil(r):
        left, right = r.cameras[0][::step], r.cameras[1][late::step]
        count = min(len(left), len(right))
        r.cameras = [left[:count], [[left[k][0], right[k][1]] for k in range(count)]]
    return spoil


def turned(axis, degrees):
    def spoil(r):
        every(10)(r)
        r.turn_camera(1, axis, math.radians(degrees))
    return spoil


def shaken(force, rate, begin=-math.inf):
    return lambda r: r.spoil_imu(motors(force, rate, begin))


def stepped(rate, force):
    def change(t, row):
        if t < FAULT_S:
            return row
        signs = (rate, -rate, rate, force, 0, -force)
        return [value + step for value, step in zip(row, signs)]
    return lambda r: r.spoil_imu(change)


def warming(rate_per_s):
    def change(t, row):
        return [row[0] + rate_per_s * t, row[1], row[2] - rate_per_s * t, *row[3:]]
    return lambda r: r.spoil_imu(change)


def mapped(change):
    return lambda r: r.spoil_imu(lambda t, row: change(row))


def without_gravity(r):
    """The linear acceleration that phones offer: what the truth's attitude says is taken off."""
    k = 0
    for row in r.imu:
        while k + 1 < len(r.truth) and r.truth[k + 1][0] <= row[0]:
            k += 1
        w, x, y, z = r.truth[k][4:8]
        up = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
        for axis in range(3):
            row[4 + axis] -= 9.81 * up[axis]


def zeros_between(r):
    for k, row in enumerate(r.imu):
        if k % 2:
            row[4:7] = [0.0, 0.0, 0.0]


def platform(motion):
    """All that is seen moves along: motion(s) -> rate about the vertical, acceleration and place in
    a frame that stands at the start. Of a device at rest, whose axes stay as they are."""
    def spoil(r):
        w, x, y, z = r.truth[0][4:8]
        to_body = [[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                   [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                   [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]]

        def in_body(v):
            return [sum(to_body[i][k] * v[k] for k in range(3)) for i in range(3)]

        def change(t, row):
            rate, acceleration, _ = motion(max(0.0, t - FAULT_S))
            w_B, f_B = in_body((0, 0, rate)), in_body(acceleration)
            return [a + b for a, b in zip(row, w_B + f_B)]

        r.spoil_imu(change)
        for row in r.truth:
            place = motion(max(0.0, r.seconds(row[0]) - FAULT_S))[2]
            for axis in range(3):
                row[1 + axis] += place[axis]
    return spoil


def train(t):
    """Brakes from 10 m/s by 1.5 m/s^2, after it went steadily: what is seen stands all the time."""
    braking = min(t, 4.0)
    a = -1.5 if 0 < t < 4 else 0.0
    return 0.0, (a, 0.0, 0.0), (0.5 * -1.5 * braking ** 2 - 6.0 * max(0.0, t - 4), 0.0, 0.0)


def lift(t):
    """A second of 1 m/s^2 up, steadily on, a second down."""
    a = 1.0 if 0 < t < 1 else -1.0 if 8 < t < 9 else 0.0
    if t < 1:
        z = 0.5 * t * t
    elif t < 8:
        z = 0.5 + (t - 1)
    elif t < 9:
        z = 7.5 + (t - 8) - 0.5 * (t - 8) ** 2
    else:
        z = 8.0
    return 0.0, (0.0, 0.0, a), (0.0, 0.0, z)


def turning_car(t):
    """A quarter of a circle of 20 m at 6 m/s, seen from within, against what goes on straight, as
    nobody knows how fast it goes; its heading is not in the truth."""
    speed, radius = 6.0, 20.0
    rate = speed / radius if 0 < t < 5 else 0.0
    angle = speed / radius * min(t, 5.0)
    after = speed * max(0.0, t - 5.0)
    place = (radius * math.sin(angle) + after * math.cos(angle) - speed * t,
             radius * (1 - math.cos(angle)) + after * math.sin(angle), 0.0)
    return rate, (0.0, speed * rate, 0.0), place


def late_right(ms):
    return every(10, ms // 5)


def with_offset(ms):
    def spoil(r):
        every(10)(r)
        for row in r.imu:
            row[0] += ms * NS // 1000
    return spoil


CASES = [
    # What nothing is wrong with.
    Case("clip", 0, "clip"), Case("flight", 0, "flight", every(10)), Case("rest", 0, "rest"),
    Case("car", 0, "car"),
    # 1: blind in motion.
    *(Case(f"clip dark {span} s", 1, "clip", None, ("--fault", f"{what}:{span}"),
           fault_s=float(span.split("-")[0]))
      for what, span in (("black", "3-9"), ("black", "2-9"), ("black", "5-12"), ("black", "8-13"),
                         ("white", "5-11"))),
    # 3: cameras that disagree.
    *(Case(f"right camera {ms} ms late", 3, "flight", late_right(ms)) for ms in (5, 10, 15)),
    *(Case(f"right camera turned {d} deg about {'xyz'[axis]}", 3, "flight", turned(axis, d))
      for axis, d in ((0, 0.5), (0, -1.5), (1, 0.5), (1, 1.0), (1, -1.0), (2, 0.5), (2, 1.0))),
    Case("no right camera", 3, "clip", None, ("--fault", "cam1:0")),
    Case("no left camera", 3, "clip", None, ("--fault", "cam0:0")),
    *(Case(f"cameras {ms} ms off the IMU", 3, "flight", with_offset(ms)) for ms in (10, 30, -20)),
    # 5: vibration.
    *(Case(f"clip shaken by {f:g} m/s^2, {w:g} rad/s", 5, "clip", shaken(f, w))
      for f, w in ((1, 0.05), (3, 0.2), (8, 0.5), (15, 1.0))),
    *(Case(f"rest shaken by {f:g} m/s^2, {w:g} rad/s", 5, "rest", shaken(f, w, FAULT_S), (), False,
           FAULT_S) for f, w in ((1, 0.05), (5, 0.3), (15, 1.0))),
    # 6: steps at rest.
    *(Case(f"gyro steps by {w:g} rad/s at rest", 6, "rest", stepped(w, 0), (), False, FAULT_S)
      for w in (0.01, 0.02, 0.03, 0.05)),
    *(Case(f"accelerometer steps by {f:g} m/s^2 at rest", 6, "rest", stepped(0, f), (), False,
           FAULT_S) for f in (0.5, 1.0)),
    Case("gyro warms up by 3 mrad/s a second", 6, "rest", warming(0.003)),
    # 7: an IMU that does not fit.
    *(Case(f"{what}{', one camera' if mono else ''}", 7, "clip", spoil,
           (("--mono",) if mono else ()) + ("--force",), True)
      for mono in (False, True)
      for what, spoil in (
          ("gyro's sign", mapped(lambda r: [-r[0], -r[1], -r[2], *r[3:]])),
          ("an axis mirrored", mapped(lambda r: [r[0], -r[1], r[2], r[3], -r[4], r[5]])),
          ("two axes exchanged", mapped(lambda r: [r[1], r[0], r[2], r[4], r[3], r[5]])),
          ("force in g", mapped(lambda r: [*r[:3], r[3] / 9.81, r[4] / 9.81, r[5] / 9.81])),
          ("gyro in degrees", mapped(lambda r: [r[0] * 57.3, r[1] * 57.3, r[2] * 57.3, *r[3:]])),
          ("gravity taken off", without_gravity), ("zeros between", zeros_between))),
    # 8: what is seen moves along.
    *(Case(f"in a {name}", 8, "rest", platform(motion), (), False, FAULT_S)
      for name, motion in (("train that brakes", train), ("lift", lift),
                           ("car that turns", turning_car))),
    # 9: repeated texture.
    Case("chequered hall and boxes", 9, "chequered"), Case("chequered hall", 9, "chequered walls"),
    # 10: texture that is hardly more than noise.
    Case("a hall that gets dark", 10, "dim", fault_s=6.0),
    Case("whitewashed hall and boxes", 10, "plain"), Case("whitewashed hall", 10, "plain walls"),
]
