"""One run of a sweep: draws its recording if need be, runs it, leaves one result, whole or none."""

import contextlib
import fcntl
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "judge"))
import figures
from recordings import frame_s

import plan

RESULT = "result.json"
ERROR = "error.txt"
KEPT = ("summary.json", "report.html", "trajectory.tum", "state.csv")
TRIED = (0, 1)  # exit status of pirvs run: tracked, or lost, a result as well


class RunError(Exception):
    pass


def folder(job, out):
    return out / "jobs" / job.name


def result(job, out):
    """What the run gave, or None. An error is none: it is tried again."""
    try:
        return json.loads((folder(job, out) / RESULT).read_text())
    except (OSError, ValueError):
        return None


def is_done(job, out):
    found = result(job, out)
    return found is not None and not found["error"]


def why_not(job, out):
    found = result(job, out)
    return found["error"] if found else "ended before its time"


@contextlib.contextmanager
def locked(path):
    """The kernel lets go of it when its holder dies, however that was."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def call(command):
    done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    return done.returncode, said[-1].strip() if said else "it said nothing"


def drawn(job, out):
    """The folder of a simulated recording; runs that share it wait for the one that draws it."""
    words = [*shlex.split(job.source.removeprefix(plan.SIM)), "--seed", str(job.seed)]
    short = hashlib.sha256(json.dumps([job.program, words]).encode()).hexdigest()[:12]
    place = out / "recordings" / f"{job.recording}-{job.seed}-{short}"
    with locked(place.with_suffix(".lock")):
        if not place.exists():
            part = place.with_suffix(".part")
            shutil.rmtree(part, ignore_errors=True)
            status, said = call([job.program, "sim", "--out", str(part), "--threads", "1", *words])
            if status != 0:
                raise RunError(f"pirvs sim: exit status {status}: {said}")
            part.replace(place)
    return place


def start_words(job, place):
    """A later seed of a recording that is there starts so many frames later."""
    if job.source.startswith(plan.SIM) or job.seed == 1:
        return []
    if not (place / "mav0/cam0/data.csv").exists():
        raise RunError("seeds above 1 need a folder with mav0, or a simulated recording")
    return ["--start", f"{(job.seed - 1) * frame_s(place):.6f}"]


def run(job, out, work):
    place = drawn(job, out) if job.source.startswith(plan.SIM) else Path(job.source)
    settings = [word for name, value in job.settings.items()
                for word in ("--set", f"{name}={value}")]
    command = [job.program, "run", str(place), "--out", str(work), "--force",
               *start_words(job, place), *settings, *job.args]
    status, said = call(command)
    if status not in TRIED:
        raise RunError(f"pirvs run: exit status {status}: {said}")
    summary = json.loads((work / "summary.json").read_text())
    found = {name: None if value == figures.FAILED else value
             for name, value in figures.of_run(summary).items()}
    return {"error": "", "status": status, "frames": summary["frames"]["in"], **found,
            "revision": summary["revision"]}


def execute(job, out):
    """Leaves result.json in the job's folder. Whoever is killed before leaves none."""
    home = folder(job, out)
    with locked(out / "locks" / job.name):
        if is_done(job, out):
            return
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir(parents=True)
        begin = time.monotonic()
        try:
            found = run(job, out, home / "run")
        except (RunError, OSError, ValueError, KeyError) as error:
            found = {"error": str(error) or type(error).__name__}
        for path in (home / "run").glob("*"):
            if path.name not in KEPT:
                path.unlink()
        found.update(wall_s=round(time.monotonic() - begin, 3), host=os.uname().nodename)
        part = home / f".{RESULT}"
        part.write_text(json.dumps(found, indent=1) + "\n")
        part.replace(home / RESULT)
