"""What a package of ours is built of, by dpkg."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "lib"))
from spdx import installed

# What the static programs take in; headers count, they become our code.
STATIC = {
    "amd64": ("libc6-dev", "libstdc++-12-dev", "libgcc-12-dev", "libgpiod-dev",
              "libjpeg62-turbo-dev", "libeigen3-dev", "libsimde-dev"),
    "arm64": ("libc6-dev-arm64-cross", "libstdc++-12-dev-arm64-cross", "libgcc-12-dev-arm64-cross",
              "libgpiod-dev", "libeigen3-dev"),
}
STACK_HEADERS = ("libeigen3-dev", "libsimde-dev")
HEADERS = (*STACK_HEADERS, "nlohmann-json3-dev", "libcli11-dev")
COMPILER = {"amd64": "g++-12", "arm64": "g++-12-aarch64-linux-gnu"}


def dynamic(binaries):
    """Packages of shared libraries, with the versions that dpkg-shlibdeps asks for."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "debian").mkdir()
        (Path(folder) / "debian/control").write_text("Source: x\n\nPackage: x\nArchitecture: any\n")
        done = subprocess.run(["dpkg-shlibdeps", "-O", *(f"-e{binary}" for binary in binaries)],
                              cwd=folder, text=True, capture_output=True)
    if done.returncode != 0:
        raise SystemExit(f"deb: dpkg-shlibdeps: {done.stderr.strip()}")
    listed = done.stdout.strip().removeprefix("shlibs:Depends=")
    for wanted in filter(None, (word.strip() for word in listed.split(","))):
        match = re.match(r"([\w.+-]+)(?: \(>= ([^)]+)\))?", wanted.split("|")[0])
        yield installed(match[1], "DYNAMIC_LINK", match[2] or "")


def parts(package, arch, binaries):
    if package == "libpirvs-dev":
        return []
    if package == "pirvsd":
        found = [installed(name, "STATIC_LINK") for name in STATIC[arch]]
    else:
        headers = STACK_HEADERS if package == "libpirvs0" else HEADERS
        found = [*dynamic(binaries), *(installed(name, "STATIC_LINK") for name in headers)]
    return [*found, installed(COMPILER[arch], "BUILD_TOOL_OF")]
