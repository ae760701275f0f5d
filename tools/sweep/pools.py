"""Where runs are made: processes of this machine, or job arrays of Slurm."""

import concurrent.futures
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import work

SWEEP = Path(__file__).resolve().parent / "sweep"


class PoolError(Exception):
    pass


def counts(jobs, out):
    """(runs that ended, those of them that failed)"""
    found = [work.result(job, out) for job in jobs]
    return (sum(result is not None for result in found),
            sum(bool(result and result["error"]) for result in found))


def command(options, listed, index):
    return [sys.executable, str(SWEEP), "--out", str(options.out.resolve()), "--list",
            str(listed.resolve()), "--run-index", str(index)]


def write_list(options, jobs, number):
    path = options.out / "lists" / f"{number}.txt"
    path.parent.mkdir(exist_ok=True)
    path.write_text("".join(f"{job.name}\n" for job in jobs))
    return path


def forget(jobs, out):
    """An error of an earlier call is no result of this one."""
    for job in jobs:
        (work.folder(job, out) / work.RESULT).unlink(missing_ok=True)


class Local:
    """Processes of pirvs, --jobs at a time. One that is killed is told, and made again later."""

    def __init__(self, options):
        self.options = options

    def wait_for_earlier(self):
        pass

    def run(self, jobs, progress):
        forget(jobs, self.options.out)
        pool = concurrent.futures.ThreadPoolExecutor(self.options.jobs)
        try:
            every = [pool.submit(work.execute, job, self.options.out) for job in jobs]
            waiting = set(every)
            while waiting:
                _, waiting = concurrent.futures.wait(
                    waiting, timeout=1, return_when=concurrent.futures.FIRST_COMPLETED)
                progress.show(*counts(jobs, self.options.out), final=not waiting)
            for one in every:
                one.result()
        finally:
            pool.shutdown(cancel_futures=True)


class Slurm:
    """Arrays of sbatch, at most --jobs tasks of one at a time.

    OUT/slurm.txt names the arrays that were sent: a call after a lost one waits for these first.
    """

    POLL_S = 1.0
    TASKS_MAX = 1000  # of one array: Slurm's own default is 1001 (MaxArraySize)

    def __init__(self, options):
        self.options, self.sent = options, options.out / "slurm.txt"
        if not shutil.which("sbatch"):
            raise PoolError("--slurm: there is no sbatch here (Debian: slurm-client)")
        text = self.ask("scontrol", "show", "config")
        found = re.search(r"MaxArraySize\s*=\s*(\d+)", text)
        self.tasks_max = min(self.TASKS_MAX, int(found[1]) - 1) if found else self.TASKS_MAX

    def ask(self, *words, check=True):
        done = subprocess.run(words, capture_output=True, text=True)
        if check and done.returncode != 0:
            raise PoolError(f"{words[0]}: {done.stderr.strip() or 'it failed'}")
        return done.stdout

    def alive(self):
        """Arrays that were sent and have tasks left."""
        ids = self.sent.read_text().split() if self.sent.exists() else []
        known = self.ask("squeue", "--noheader", "--me", "--format=%A %F").split()
        return [number for number in ids if number in known]

    def wait_for_earlier(self):
        if self.alive():
            print(f"waiting for arrays of an earlier call: {' '.join(self.alive())}",
                  file=sys.stderr)
        while self.alive():
            time.sleep(self.POLL_S)

    def send(self, jobs, number):
        listed = write_list(self.options, jobs, f"{os.getpid()}-{number}")
        script = "exec " + shlex.join(command(self.options, listed, 0)[:-1])
        logs = self.options.out.resolve() / "logs"
        logs.mkdir(exist_ok=True)
        array = f"--array=0-{len(jobs) - 1}%{self.options.jobs}"
        return self.ask("sbatch", "--parsable", "--job-name=pirvs-sweep", array,
                        f"--chdir={self.options.out.resolve()}", f"--output={logs}/%A_%a.txt",
                        *shlex.split(self.options.sbatch),
                        f"--wrap={script} $SLURM_ARRAY_TASK_ID").strip().split(";")[0]

    def run(self, jobs, progress):
        forget(jobs, self.options.out)
        ids = []
        try:
            for first in range(0, len(jobs), self.tasks_max):
                ids.append(self.send(jobs[first:first + self.tasks_max], first))
                self.sent.write_text("\n".join(ids) + "\n")
            while self.alive():
                progress.show(*counts(jobs, self.options.out))
                time.sleep(self.POLL_S)
        except KeyboardInterrupt:
            for number in ids:
                self.ask("scancel", number, check=False)
            raise
        progress.show(*counts(jobs, self.options.out), final=True)
