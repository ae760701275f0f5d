#!/usr/bin/env python3
"""A device's serial line as docs/device.md describes it: a pty, whose name it prints.
Pose lines until `poses off`; each command is answered by one line. Ends with its standard input."""
import os
import select
import sys
import time
import tty


def answer(line):
    words = line.split()
    if not words:
        return None
    if words[0] in ("reset", "stop", "pose", "parameter", "map", "record", "node", "poses"):
        return "ok " + " ".join(words[:2] if words[0] in ("map", "record", "node") else words[:1])
    return "error no such command"


def main():
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    print(os.ttyname(theirs), flush=True)
    poses, text = True, b""
    while True:
        ready, _, _ = select.select([ours, sys.stdin], [], [], 0.1)
        if sys.stdin in ready and not sys.stdin.buffer.read1(1):
            return
        if poses:
            os.write(ours, b"%.6f 0 0 0 0 0 0 1 tracking 0.9\r\n" % time.monotonic())
        if ours not in ready:
            continue
        text += os.read(ours, 4096)
        *lines, text = text.replace(b"\r", b"\n").split(b"\n")
        for line in lines:
            said = answer(line.decode("ascii", "replace"))
            if said == "ok poses":
                poses = False
            if said:
                os.write(ours, said.encode() + b"\r\n")


main()
