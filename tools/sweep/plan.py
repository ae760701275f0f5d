"""Which runs a sweep is made of, and their names, which stay when the sweep grows."""

import collections
import hashlib
import itertools
import json
import re
import shlex
from pathlib import Path

PLAN = "plan.json"
SIM = "sim:"
SEEDS_MAX = 100_000

# recording, seed, settings {parameter: value}: what the table says. source: a path, or `sim:` and
# options. program, args: what runs. key: all that changes the result.
Job = collections.namedtuple("Job", "name recording source seed settings program args key")


class PlanError(Exception):
    pass


def seeds(text):
    """[1, 2, 3, 8] of "1-3,8"."""
    found = []
    for part in text.split(","):
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", part.strip())
        if not match:
            raise PlanError(f"--seeds {text}: {part!r} is no number and no range like 1-5")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= last or last - first >= SEEDS_MAX:
            raise PlanError(f"--seeds {text}: {part}: from 1 on, the first before the last")
        found += range(first, last + 1)
    return list(dict.fromkeys(found))


def axis(text):
    """("name", ["a", "b"]) of "name=a,b"."""
    name, equals, values = text.partition("=")
    values = [value.strip() for value in values.split(",")]
    if not (equals and re.fullmatch(r"[a-z0-9_.]+", name) and all(values)):
        raise PlanError(f"--set {text}: write name=value,value,...")
    return name, list(dict.fromkeys(values))


def recording(text):
    """(name, source) of "[NAME=]PATH" or "[NAME=]sim:OPTIONS"."""
    match = re.match(r"([\w.+-]+)=(.+)", text, re.S)
    name, source = (match[1], match[2]) if match else (None, text)
    if source.startswith(SIM):
        if {"--seed", "--out"} & {word.split("=")[0] for word in shlex.split(source)}:
            raise PlanError(f"--recording {text}: --seed and --out are the sweep's to give")
        return name or "sim", source
    path = Path(source)
    if not path.exists():
        raise PlanError(f"--recording {text}: there is no {source}")
    return name or re.sub(r"[^\w.+-]", "_", path.resolve().name), str(path.resolve())


def digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def stamp(source):
    """What changes when the recording does."""
    path = Path(source)
    if source.startswith(SIM):
        return None
    parts = [path] if path.is_file() else sorted((path / "mav0").glob("*/data.csv"))
    return [(str(part), part.stat().st_size, part.stat().st_mtime_ns) for part in parts]


def make(options):
    """Every job: recordings x settings x seeds, in that order."""
    if not options.recording:
        raise PlanError("no --recording; --help shows how")
    if options.jobs < 1:
        raise PlanError("--jobs: at least 1")
    program = Path(options.pirvs).resolve()
    if not program.is_file():
        raise PlanError(f"--pirvs {options.pirvs}: there is no such program; `make` builds it")
    recordings = [recording(text) for text in options.recording]
    names = [name for name, _ in recordings]
    if len(set(names)) < len(names):
        raise PlanError("two recordings have one name; write NAME=PATH")
    axes = [axis(text) for text in options.set]
    if len({name for name, _ in axes}) < len(axes):
        raise PlanError("--set names a parameter twice; write name=a,b")
    identity, numbers, jobs = digest(program), seeds(options.seeds), []
    for name, source in recordings:
        about = stamp(source)
        for values in itertools.product(*(values for _, values in axes)):
            settings = dict(zip((axis_name for axis_name, _ in axes), values))
            for seed in numbers:
                key = [identity, source, about, seed, settings, options.args]
                short = hashlib.sha256(json.dumps(key).encode()).hexdigest()[:12]
                jobs.append(Job(f"{name}-{seed}-{short}", name, source, seed, settings,
                                str(program), options.args, short))
    return jobs


def save(jobs, out):
    part = out / f".{PLAN}"
    part.write_text(json.dumps([job._asdict() for job in jobs], indent=1) + "\n")
    part.replace(out / PLAN)


def load(out):
    return [Job(**fields) for fields in json.loads((out / PLAN).read_text())]
