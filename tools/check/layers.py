"""Includes follow the table of docs/architecture.md; below tools no header brings in a heap."""
import re

MODULE = re.compile(r"modules/([^/]+)/")
INCLUDE = re.compile(r'^\s*#\s*include\s+(["<])([^">]+)[">]')

# A folder and what it may include besides itself, by prefix. The longest matching folder counts.
# A folder that is missing here may include everything.
ALLOWED = {
    # The data that crosses the contract: stamps, vectors, handles, a view of an image.
    "bsp/api": ["core/base/", "core/math/types.h", "core/kernels/image.h", "core/store/handle.h"],
    "bsp": ["bsp/api/", "core/"],
    # A chip: the rows of register.h, and for its emulator the emulated bus.
    "bsp/drivers": ["bsp/api/", "bsp/drivers/", "core/"],
    "bsp/linux": ["bsp/api/", "bsp/drivers/", "core/"],
    "bsp/bare": ["bsp/api/", "bsp/drivers/", "core/"],
    "core": ["core/"],
}

# Who may include whom among the modules, from the ground up: an arrow goes to an earlier row alone,
# so that there is no circle. All may include core. A module that is missing here is refused.
MODULES = {
    "state": [],
    "imu": ["state"],
    "wheels": ["imu"],
    "calibration": ["imu", "wheels"],
    "frontend": [],
    "map": ["state", "imu", "wheels", "frontend"],
    "matching": ["map", "state", "frontend"],
    "standstill": ["imu", "frontend"],
    "health": [],
    "tracking": ["state", "imu", "wheels", "frontend", "map", "matching", "standstill", "health"],
    "mapping": ["state", "imu", "wheels", "map", "matching"],
    "output": ["state", "imu", "health"],
    "exposure": [],
    "door": ["calibration", "imu", "wheels", "frontend"],
    "recorder": ["calibration", "imu", "door"],
    "link": ["state", "imu", "wheels", "health", "output", "door"],
    "gnss": ["door"],
    "fusion": ["state", "calibration", "health", "output", "door"],
    "stream": ["state", "imu", "health", "output", "fusion"],
}
# Edge modules: data of the machine enters or leaves here.
EDGE = ("imu", "door", "recorder", "stream")
MODULES["app"] = list(MODULES)  # wires all the others
EDGE += ("app",)
for module, others in MODULES.items():
    ALLOWED[f"modules/{module}"] = ["core/", *(f"modules/{other}/" for other in others),
                                    *(["bsp/api/"] if module in EDGE else [])]
# `app` wires all the others, so nobody below it may know it.
ONLY_FROM = {"modules/app/": ("modules/app/", "board/", "tests/", "tools/")}
BELOW_TOOLS = ("bsp/", "core/", "modules/")
HEAP_HEADERS = {
    "any", "deque", "forward_list", "fstream", "functional", "iostream", "list", "map", "memory",
    "ostream", "queue", "regex", "set", "sstream", "stack", "string", "unordered_map",
    "unordered_set", "vector",
}
# The board's word on what its memory holds, found on the include path: core names no board.
BOARD_LIMITS = ("core/base/limits.h", "board_limits.h")
FOREIGN = ("opencv2/", "yaml-cpp/", "nlohmann/", "CLI/", "gtest/", "benchmark/")


def is_test(path):
    return re.search(r"_(test|bench)\.(cc|h)$", path) is not None


def allowed_of(path):
    folders = [f for f in ALLOWED if path.startswith(f + "/")]
    return (max(folders, key=len), ALLOWED[max(folders, key=len)]) if folders else (None, None)


def own_folder(path):
    return path.rsplit("/", 1)[0] + "/"


def forbidden(path, quote, header):
    """Why `path` may not include `header`, or None."""
    if quote == '"':
        for target, users in ONLY_FROM.items():
            if header.startswith(target) and not path.startswith(users):
                return f"{header}: only {' '.join(users)} may know it"
        module = MODULE.match(path)
        if module and module[1] not in MODULES:
            return f"modules/{module[1]} has no row in the table of modules (tools/check/layers.py)"
        folder, allowed = allowed_of(path)
        if folder and not header.startswith((own_folder(path), *allowed)):
            return f"{header}: {folder} may include {' '.join(allowed)} alone"
    elif path.startswith(BELOW_TOOLS):
        if header in HEAP_HEADERS or header.startswith(FOREIGN):
            return f"<{header}>: not below tools"
    return None


def check(tree, options):
    del options
    findings = []
    for path, text in tree.items():
        if not path.endswith((".h", ".cc")) or is_test(path):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            match = INCLUDE.match(line)
            if match and (path, match[2]) == BOARD_LIMITS:
                continue
            why = match and forbidden(path, *match.groups())
            if why:
                findings.append(f"{path}:{number}: {why}")
            elif match and match[1] == '"' and match[2] not in tree:
                findings.append(f"{path}:{number}: {match[2]}: no such file from the root")
    return findings


def self_test(options):
    bad = {
        "core/a.h": '#include "modules/imu/imu.h"',
        "core/b.cc": "#include <vector>",
        "modules/map/c.cc": '#include "bsp/api/clock.h"',
        "modules/map/d.cc": '#include "modules/app/app.h"',
        "modules/map/e.cc": "#include <opencv2/core.hpp>",
        "modules/mapping/m.cc": '#include "modules/tracking/t.h"',
        "modules/tracking/t.cc": '#include "modules/mapping/m.h"',
        "modules/state/s.cc": '#include "modules/map/map.h"',
        "modules/novel/n.cc": '#include "core/base/time.h"',
        "bsp/api/f.h": '#include "core/sched/scheduler.h"',
        "bsp/linux/g.cc": '#include "tools/run/run.h"',
        "tools/h.cc": '#include "nowhere.h"',
        "core/base/h.h": '#include "board_limits.h"',
    }
    good = {
        "modules/app/a.cc": '#include "bsp/api/clock.h"\n#include "modules/app/a.h"',
        "modules/app/a.h": '#include "core/base/time.h"',
        "bsp/api/clock.h": '#include "core/base/time.h"',
        "core/base/time.h": "#include <cstdint>",
        "core/base/limits.h": '#include "board_limits.h"',
        "core/base/time_test.cc": "#include <vector>",
        "tools/run/b.cc": "#include <vector>",
    }
    others = {"modules/imu/imu.h": "", "modules/tracking/t.h": "", "modules/mapping/m.h": "",
              "modules/map/map.h": "", "core/sched/scheduler.h": "", "tools/run/run.h": ""}
    blind = [f"{p}: {t}" for p, t in bad.items()
             if not check({p: t, **good, **others}, options)]
    return blind + [f"that this is fine: {f}" for f in check({**good, **others}, options)]
