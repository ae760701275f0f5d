"""A device at a broker of MQTT: its poses, and whether it is there.

Topics, below a prefix (`pirvs`):
  PREFIX/DEVICE/pose    {"n", "t", "p", "q", "health", "confidence"}: n counts from 0, so that a
                        receiver knows what it missed; t in s; T_WB, q as x y z w; by QoS 0
  PREFIX/DEVICE/status  online or offline, retained; the broker itself says offline when it breaks
"""

import csv
import json
import time

import paho.mqtt.client as mqtt

PREFIX = "pirvs"
KEEP_ALIVE_S = 15
JITTER = 0.05  # of a period: a pose that is early by less is in time
QUEUE_MAX = 1000  # poses kept by QoS 1 while the broker is away; older than that is of no use


def address(text):
    """("host", 1883) of "host" or "host:1883"."""
    host, colon, port = text.partition(":")
    if not host or (colon and not (port.isdigit() and 0 < int(port) < 65536)):
        raise ValueError(f"{text}: write HOST or HOST:PORT")
    return host, int(port) if colon else 1883


def pose_of_line(line):
    """A pose line of pirvsd, `t x y z qx qy qz qw health confidence`, or None."""
    words = line.split()
    if len(words) < 10:
        return None
    try:
        numbers = [float(word) for word in words[:8]]
        return {"t": numbers[0], "p": numbers[1:4], "q": numbers[4:8], "health": words[8],
                "confidence": float(words[9])}
    except ValueError:
        return None


def poses_of_run(folder):
    """Every pose of a finished run (state.csv)."""
    with open(folder / "state.csv", newline="", encoding="utf-8") as file:
        rows = csv.DictReader((line.lstrip("#") for line in file))
        return [{"t": int(row["t_ns"]) * 1e-9,
                 "p": [float(row[name]) for name in ("px", "py", "pz")],
                 "q": [float(row[name]) for name in ("qx", "qy", "qz", "qw")],
                 "health": row["health"], "confidence": float(row["confidence"])}
                for row in rows]


def text(number, pose):
    """0.1 mm and 1e-5 rad: finer than any estimate, and a third shorter."""
    return json.dumps({"n": number, "t": round(pose["t"], 6),
                       "p": [round(value, 4) for value in pose["p"]],
                       "q": [round(value, 5) for value in pose["q"]], "health": pose["health"],
                       "confidence": round(pose["confidence"], 2)}, separators=(",", ":"))


class Device:
    """Sends what it is given, at most rate_hz; connects again when the broker was away."""

    def __init__(self, name, broker, rate_hz, qos=0, prefix=PREFIX):
        if not name or set(name) & set("+#/\0"):
            raise ValueError(f"{name!r}: a device's name has no + # /")
        self.topic, self.qos, self.period_s = f"{prefix}/{name}", qos, 1.0 / rate_hz
        self.number, self.next_s, self.dropped = 0, None, 0
        self.client = mqtt.Client(client_id=name, clean_session=True)
        self.client.max_queued_messages_set(QUEUE_MAX)
        self.client.will_set(f"{self.topic}/status", "offline", qos=1, retain=True)
        self.client.on_connect = self._on_connect
        self.client.connect(*broker, keepalive=KEEP_ALIVE_S)
        self.client.loop_start()

    def _on_connect(self, client, _userdata, _flags, status):
        if status == 0:
            client.publish(f"{self.topic}/status", "online", qos=1, retain=True)

    def due(self, pose):
        """Thins out to the rate by the poses' own time, which may begin anew."""
        ahead = 0.0 if self.next_s is None else (self.next_s - pose["t"]) / self.period_s
        if JITTER < ahead <= 1 + JITTER:
            return False
        keeps_pace = self.next_s is not None and -1 < ahead <= JITTER
        self.next_s = (self.next_s if keeps_pace else pose["t"]) + self.period_s
        return True

    def send(self, pose):
        """(topic, payload) that went to the broker. What QoS 0 cannot send now is dropped."""
        payload = text(self.number, pose)
        self.number += 1
        told = self.client.publish(f"{self.topic}/pose", payload, qos=self.qos)
        if told.rc != mqtt.MQTT_ERR_SUCCESS and self.qos == 0:
            self.dropped += 1
        return f"{self.topic}/pose", payload

    def close(self, wait_s=5.0):
        told = self.client.publish(f"{self.topic}/status", "offline", qos=1, retain=True)
        end = time.monotonic() + wait_s
        while not told.is_published() and time.monotonic() < end:
            time.sleep(0.02)
        self.client.disconnect()
        self.client.loop_stop()
