#!/usr/bin/env python3
"""Stands in for pirvs in the test: answers at once, the same to the same words.

`HANG` in the folder of the environment's FAKE_PIRVS lets the run of seed 7 with a.b=1 wait to be
killed.
"""
import hashlib
import json
import os
import sys
import time
from pathlib import Path

words = sys.argv[1:]
out = Path(words[words.index("--out") + 1])
out.mkdir(parents=True, exist_ok=True)
if "bad.value=1" in words:
    print("error: no such parameter: bad.value", file=sys.stderr)
    sys.exit(2)
if words[0] == "sim":
    (out / "words").write_text(" ".join(words[words.index("--threads"):]))
    sys.exit(0)
control = Path(os.environ["FAKE_PIRVS"])
with open(control / "calls", "a", encoding="utf-8") as calls:
    calls.write(f"{os.getpid()}\n")
recording = Path(words[1])
heard = (recording / "words").read_text() if (recording / "words").exists() else ""
if heard.endswith("--seed 7") and "a.b=1" in words and (control / "HANG").exists():
    (control / "hangs").write_text(str(os.getpid()))
    (control / "hangs").rename(control / "hanging")
    time.sleep(300)
start = words[words.index("--start"):][:2] if "--start" in words else []
told = " ".join([heard, *(word for word in words if "=" in word), *start])
error = int(hashlib.sha256(told.encode()).hexdigest()[:4], 16) / 1e6
(out / "summary.json").write_text(json.dumps({
    "status": "tracked", "revision": "fake", "told": told,
    "frames": {"in": 10, "tracked": 9, "lost": 0, "dropped": 0},
    "evaluation": {"ate_rmse_m": error, "rpe_m": error / 2, "rpe_deg": 0.1},
    "timing_ms": {"end_to_end_ms": {"mean": 2.0}}}))
(out / "trace.json").write_text("large")
