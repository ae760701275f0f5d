"""No line names a path that exists on one person's machine only; no file ends without a newline."""
import re

# Where people and their machines keep a checkout. System folders (/usr, /dev, /tmp ...) are fine.
PRIVATE_PATH = re.compile(r"(?<![\w.)}/~-])/(?:home|root|Users|mnt|media|opt|srv|work)/\w")
MERGE = re.compile(r"^(<{7}|>{7}) ")
SELF = "tools/check/words.py"
CORPUS = "tests/fuzz/corpus/"  # bytes for parsers, not lines of ours


def check(tree, options):
    del options
    findings = []
    for path, text in tree.items():
        if path == SELF or path.startswith(CORPUS):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if PRIVATE_PATH.search(line):
                findings.append(f"{path}:{number}: a path of one machine; name it by an option")
            if MERGE.match(line):
                findings.append(f"{path}:{number}: a merge was left open")
        if text and not text.endswith("\n"):
            findings.append(f"{path}:{text.count(chr(10)) + 1}: the last line needs a newline")
    return findings


def self_test(options):
    bad = ['see /home/ada/pirvs\n', 'open("/work/data.csv")\n', "<<<<<<< ours\n", "no newline"]
    good = "https://example.org/home/x a /usr/lib/x build/work/x /dev/video0\n"
    blind = [repr(text) for text in bad if not check({"a": text}, options)]
    return blind + [f"that this is fine: {good}" for _ in check({"a": good}, options)]
