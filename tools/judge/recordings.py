"""The table of recordings: reads it, finds each recording, draws what is missing."""

import collections
import json
import os
import shlex
import shutil
import subprocess
import time
from pathlib import Path

PARTS = ("decide", "confirm", "still", "mode")
SOURCES = ("data", "given", "sim", "as")
DRAWN = "drawn.json"  # beside mav0: which options drew it

# row: as it is shown; recording: rows of one recording weigh as one.
Row = collections.namedtuple("Row", "name recording kind part start_s options source")


class TableError(Exception):
    pass


def read_table(text):
    """Every row of the table, one for each start."""
    rows, sources = [], {}
    for number, line in enumerate(text.splitlines(), 1):
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if len(words) < 7 or words[2] not in PARTS or words[5] not in SOURCES:
            raise TableError(f"line {number}: not a recording: {line}")
        name, kind, part, starts, options, *source = words
        if source[0] == "as" and source[1] not in sources:
            raise TableError(f"line {number}: {source[1]} does not stand above")
        source = sources.setdefault(name, sources[source[1]] if source[0] == "as" else source)
        for start in starts.split(","):
            shown = name if "," not in starts else f"{name}@{start}"
            rows.append(Row(shown, name.split(".")[0], kind, part, float(start),
                            [] if options == "-" else shlex.split(options), source))
    names = [row.name for row in rows]
    for name in names:
        if names.count(name) > 1:
            raise TableError(f"{name} stands there twice")
    return rows


class Places:
    """Where recordings lie."""

    def __init__(self, environment):
        cache = Path(environment.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        self.data = Path(environment.get("PIRVS_DATA") or "../shared/data")
        self.given = environment.get("EVAL_HYBRID")
        self.drawn = Path(environment.get("EVAL_DATA") or cache / "pirvs-eval")

    def find(self, row):
        """(folder, None), or (None, why there is none)."""
        kind, name = row.source[0], row.source[1]
        if kind == "sim":
            return self.drawn / row.recording, None
        if kind == "given" and not self.given:
            return None, "EVAL_HYBRID names no folder"
        folder = (Path(self.given) if kind == "given" else self.data) / name
        if not (folder / "mav0").is_dir():
            variable = "EVAL_HYBRID" if kind == "given" else "PIRVS_DATA"
            return None, f"no recording at {folder}: set {variable}"
        return folder, None


def is_drawn(folder, options):
    try:
        return json.loads((folder / DRAWN).read_text())["options"] == options
    except (OSError, ValueError, KeyError):
        return False


def draw(program, folder, options):
    """Draws one recording; it is there as a whole or not at all."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run([program, "sim", "--out", str(folder), "--format", "jpg", "--blur", "2",
                           "--threads", "2", *options], capture_output=True, text=True)
    if done.returncode != 0:
        raise TableError(f"{folder.name}: pirvs sim: {done.stderr.strip()}")
    (folder / DRAWN).write_text(json.dumps({"options": options}) + "\n")


def draw_missing(program, rows, places, say):
    wanted = {}
    for row in rows:
        if row.source[0] == "sim":
            options = row.source[1:]
            if wanted.setdefault(row.recording, options) != options:
                raise TableError(f"{row.name}: its recording is drawn in two ways")
    missing = {name: options for name, options in wanted.items()
               if not is_drawn(places.drawn / name, options)}
    for count, (name, options) in enumerate(missing.items(), 1):
        begin = time.monotonic()
        say(f"drawing {count}/{len(missing)} {name}")
        draw(program, places.drawn / name, options)
        say(f"drawing {count}/{len(missing)} {name}: {time.monotonic() - begin:.0f} s", True)


def frame_s(folder):
    """Seconds from one frame to the next."""
    with open(folder / "mav0/cam0/data.csv", encoding="utf-8") as file:
        stamps = []
        for line in file:
            if line[:1].isdigit():
                stamps.append(int(line.split(",")[0]))
            if len(stamps) == 11:
                break
    steps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
    return steps[len(steps) // 2] * 1e-9


def identity(folder):
    """What changes when the recording does."""
    files = [folder / "mav0/imu0/data.csv", folder / "mav0/cam0/data.csv"]
    return [str(folder.resolve()), *(os.stat(file).st_size for file in files)]
