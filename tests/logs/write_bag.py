#!/usr/bin/python3
"""write_bag.py ASL_FOLDER DURATION_S COMPRESSION OUT: a ROS 1 bag, by ROS's own writer.

Debian's python3-rosbag and python3-sensor-msgs, python3-nav-msgs. COMPRESSION: none, bz2 or lz4.
"""
import sys

import genpy
import rosbag
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CompressedImage, Imu

sys.dont_write_bytecode = True

from clip_rows import rows

TOPICS = {"left": "/cam0/image_raw/compressed", "right": "/cam1/image_raw/compressed",
          "imu": "/imu0", "truth": "/odometry"}


def message(kind, content):
    if kind == "imu":
        out = Imu()
        w, f = out.angular_velocity, out.linear_acceleration
        w.x, w.y, w.z, f.x, f.y, f.z = content
    elif kind == "truth":
        out = Odometry(child_frame_id="imu")
        p, q = out.pose.pose.position, out.pose.pose.orientation
        p.x, p.y, p.z, q.w, q.x, q.y, q.z = content
    else:
        out = CompressedImage(format="jpeg", data=content)
    out.header.frame_id = kind
    return out


def main():
    folder, duration_s, compression, path = sys.argv[1:]
    with rosbag.Bag(path, "w", compression=compression) as bag:
        for t, kind, content in rows(folder, float(duration_s)):
            out = message(kind, content)
            out.header.stamp = genpy.Time(t // 10**9, t % 10**9)
            bag.write(TOPICS[kind], out, out.header.stamp)


main()
