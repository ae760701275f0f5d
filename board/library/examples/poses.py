#!/usr/bin/env python3
"""Poses of an ASL recording with PGM images, one a line (TUM): poses.py FOLDER/mav0 CALIBRATION"""
import csv
import sys
from ctypes import (CDLL, Structure, byref, c_char_p, c_double, c_float, c_int64, c_uint32,
                    c_void_p, sizeof)
from pathlib import Path

STEPPED, AT_FRAME = 1, 1
pirvs = CDLL("libpirvs.so.0")
pirvs.pirvs_last_error.restype = c_char_p


class Struct(Structure):
    def __init__(self, **fields):
        super().__init__(size=sizeof(type(self)), **fields)


class Config(Struct):
    _fields_ = [("size", c_uint32), ("mode", c_uint32), ("calibration", c_char_p),
                ("folder", c_char_p), ("cores", c_uint32), ("mono", c_uint32),
                ("monotonic", c_uint32), ("points", c_uint32), ("context", c_void_p),
                ("on_pose", c_void_p), ("on_frame", c_void_p), ("on_news", c_void_p)]


class Imu(Struct):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("t_ns", c_int64),
                ("w_rad_s", c_double * 3), ("f_m_s2", c_double * 3)]


class Images(Struct):
    _fields_ = [("size", c_uint32), ("stride", c_uint32), ("t_ns", c_int64),
                ("image", c_char_p * 2)]


class Pose(Struct):
    _fields_ = [("size", c_uint32), ("health", c_uint32), ("t_ns", c_int64),
                ("t_frame_ns", c_int64), ("p_m", c_double * 3), ("q_xyzw", c_double * 4),
                ("v_m_s", c_double * 3), ("w_rad_s", c_double * 3), ("cov", c_double * 81),
                ("confidence", c_float), ("reasons", c_uint32), ("resets", c_uint32),
                ("jump_m", c_float), ("jump_rad", c_float), ("epoch", c_uint32),
                ("in_map", c_uint32), ("dead_reckoning", c_uint32)]


def call(name, *arguments):
    status = getattr(pirvs, "pirvs_" + name)(*arguments)
    if status < 0:
        sys.exit(f"poses: {pirvs.pirvs_last_error().decode()}")
    return status


def rows(path):
    return (row for row in csv.reader(path.open()) if not row[0].startswith("#"))


def read_pgm(path):  # P5, width, height, 255, pixels
    return path.read_bytes().split(maxsplit=3)[3][4:] if path.exists() else None


def main(mav0, calibration):
    slam, pose = c_void_p(), Pose()
    call("create", byref(Config(mode=STEPPED, calibration=calibration.encode())), byref(slam))
    call("start", slam)
    frames = rows(mav0 / "cam0/data.csv")
    frame = next(frames, None)
    for t, *values in rows(mav0 / "imu0/data.csv"):
        while frame and int(frame[0]) < int(t):
            name = frame[1].strip()
            pixels = [read_pgm(mav0 / camera / "data" / name) for camera in ("cam0", "cam1")]
            call("feed_images", slam, byref(Images(t_ns=int(frame[0]), image=tuple(pixels))))
            frame = next(frames, None)
        w, f = (c_double * 3)(*map(float, values[:3])), (c_double * 3)(*map(float, values[3:6]))
        call("feed_imu", slam, byref(Imu(t_ns=int(t), w_rad_s=w, f_m_s2=f)))
        while call("next_pose", slam, AT_FRAME, byref(pose)) == 0:
            seconds, ns = divmod(pose.t_ns, 10**9)
            print(f"{seconds}.{ns:09}", *(f"{x:.9f}" for x in (*pose.p_m, *pose.q_xyzw)))
    call("stop", slam)
    pirvs.pirvs_destroy(slam)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
