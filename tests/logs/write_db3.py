#!/usr/bin/env python3
"""write_db3.py ASL_FOLDER DURATION_S OUT: a rosbag2 folder with sqlite3, in CDR of its own.

The tables are those of rosbag2_storage_sqlite3.
"""
import sqlite3
import struct
import sys
from pathlib import Path

sys.dont_write_bytecode = True

from clip_rows import rows

TOPICS = {"left": ("/cam0/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
          "right": ("/cam1/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
          "imu": ("/imu0", "sensor_msgs/msg/Imu"), "truth": ("/odometry", "nav_msgs/msg/Odometry")}


class Cdr:
    """Little-endian, each number at a multiple of its size behind the head."""

    def __init__(self):
        self.bytes = bytearray()

    def put(self, form, *values):
        for value in values:
            size = struct.calcsize(form)
            self.bytes += b"\0" * (-len(self.bytes) % size)
            self.bytes += struct.pack("<" + form, value)

    def text(self, value):
        self.put("I", len(value) + 1)
        self.bytes += value.encode() + b"\0"

    def message(self):
        return b"\0\1\0\0" + bytes(self.bytes)


def message(t, kind, content):
    cdr = Cdr()
    cdr.put("i", t // 10**9)
    cdr.put("I", t % 10**9)
    cdr.text(kind)
    if kind == "imu":
        cdr.put("d", 0, 0, 0, 1, *[0] * 9, *content[:3], *[0] * 9, *content[3:], *[0] * 9)
    elif kind == "truth":
        cdr.text("imu")
        x, y, z, qw, qx, qy, qz = content
        cdr.put("d", x, y, z, qx, qy, qz, qw, *[0] * 36, *[0] * 6, *[0] * 36)
    else:
        cdr.text("jpeg")
        cdr.put("I", len(content))
        cdr.bytes += content
    return cdr.message()


def main():
    folder, duration_s, path = sys.argv[1:]
    out = Path(path)
    out.mkdir()
    db = sqlite3.connect(out / "clip_0.db3")
    db.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
               " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
    db.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
               " timestamp INTEGER NOT NULL, data BLOB NOT NULL)")
    ids = {kind: i for i, kind in enumerate(TOPICS, 1)}
    for kind, (name, type_name) in TOPICS.items():
        db.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (ids[kind], name, type_name))
    for t, kind, content in rows(folder, float(duration_s)):
        db.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                   (ids[kind], t, message(t, kind, content)))
    db.commit()
    (out / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
        "  relative_file_paths:\n    - clip_0.db3\n")


main()
