"""Runs every row some times, starts a frame apart, and keeps what is done already."""

import collections
import concurrent.futures
import hashlib
import json
import shutil
import subprocess
import threading
import time

import figures
import recordings

KEPT = ("summary.json", "report.html")
KEY = "key.json"

Job = collections.namedtuple("Job", "row index command out key alone")


class RunError(Exception):
    pass


def program_hash(program):
    with open(program, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def jobs(rows, folders, program, out, count):
    """One for each run; those on several cores have the machine for themselves."""
    digest = program_hash(program)
    for row in rows:
        folder = folders[row.name]
        step_s = recordings.frame_s(folder)
        for index in range(count(row)):
            start_s = f"{row.start_s + index * step_s:.6f}"
            options = ["--start", start_s, *row.options]
            key = [digest, recordings.identity(folder), options]
            place = out / "runs" / row.name / str(index)
            command = [program, "run", str(folder), *options, "--force", "--out", str(place)]
            yield Job(row, index, command, place, key, "--cores" in row.options)


def is_done(job):
    try:
        return json.loads((job.out / KEY).read_text()) == job.key
    except (OSError, ValueError):
        return False


def execute(job):
    if is_done(job):
        return
    shutil.rmtree(job.out, ignore_errors=True)
    done = subprocess.run(job.command, capture_output=True, text=True)
    if done.returncode not in (0, 1):  # 1: lost at the end, a result as well
        raise RunError(f"{' '.join(job.command)}: exit status {done.returncode}\n"
                       f"{done.stderr.strip()}")
    for path in job.out.iterdir():
        if path.name not in KEPT:
            path.unlink()
    (job.out / KEY).write_text(json.dumps(job.key))


def execute_all(all_jobs, parallel, say):
    todo = [job for job in all_jobs if not is_done(job)]
    begin, lock, done = time.monotonic(), threading.Lock(), 0

    def one(job):
        nonlocal done
        execute(job)
        with lock:
            done += 1
            passed = time.monotonic() - begin
            left = passed / done * (len(todo) - done)
            say(f"running {done}/{len(todo)} {job.row.name}: {passed:.0f} s, {left:.0f} s left")

    pool = concurrent.futures.ThreadPoolExecutor(parallel)
    try:
        list(pool.map(one, [job for job in todo if not job.alone]))
    finally:
        pool.shutdown(cancel_futures=True)
    for job in todo:
        if job.alone:
            one(job)
    if todo:
        say(f"{len(todo)} runs, {len(all_jobs) - len(todo)} were there: "
            f"{time.monotonic() - begin:.0f} s", True)


def results(all_jobs):
    """{row: [figures of each run]}, in the order of the table, and the program's revision."""
    out, revision = {}, "unknown"
    for job in all_jobs:
        summary = json.loads((job.out / "summary.json").read_text())
        out.setdefault(job.row.name, []).append(figures.of_run(summary))
        revision = summary["revision"]
    return {"revision": revision, "rows": out}
