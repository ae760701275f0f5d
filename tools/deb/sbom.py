"""What a package of ours is built of, by dpkg, and its bill of materials in SPDX 2.3."""

import collections
import hashlib
import json
import re
import subprocess
import tempfile
from datetime import datetime, timezone
from pathlib import Path

# how: DYNAMIC_LINK, STATIC_LINK, or BUILD_TOOL_OF. least: the version a dynamic one must have.
Part = collections.namedtuple("Part", "name version source source_version how least")

# What the static programs take in; headers count, they become our code.
STATIC = {
    "amd64": ("libc6-dev", "libstdc++-12-dev", "libgcc-12-dev", "libgpiod-dev",
              "libjpeg62-turbo-dev", "libeigen3-dev", "libsimde-dev"),
    "arm64": ("libc6-dev-arm64-cross", "libstdc++-12-dev-arm64-cross", "libgcc-12-dev-arm64-cross",
              "libgpiod-dev", "libeigen3-dev"),
}
HEADERS = ("libeigen3-dev", "libsimde-dev", "nlohmann-json3-dev", "libcli11-dev")
COMPILER = {"amd64": "g++-12", "arm64": "g++-12-aarch64-linux-gnu"}


def part(name, how, least=""):
    shown = subprocess.run(
        ["dpkg-query", "-W", "-f",
         "${Version}\t${source:Package}\t${source:Version}\n", name],
        text=True, capture_output=True)
    if shown.returncode != 0:
        raise SystemExit(f"deb: {name} is not installed: tools/setup/install")
    return Part(name, *shown.stdout.splitlines()[0].split("\t"), how, least)


def dynamic(programs):
    """Packages of shared libraries, with the versions that dpkg-shlibdeps asks for."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "debian").mkdir()
        (Path(folder) / "debian/control").write_text("Source: x\n\nPackage: x\nArchitecture: any\n")
        done = subprocess.run(["dpkg-shlibdeps", "-O", *(f"-e{program}" for program in programs)],
                              cwd=folder, text=True, capture_output=True)
    if done.returncode != 0:
        raise SystemExit(f"deb: dpkg-shlibdeps: {done.stderr.strip()}")
    listed = done.stdout.strip().removeprefix("shlibs:Depends=")
    for wanted in filter(None, (word.strip() for word in listed.split(","))):
        match = re.match(r"([\w.+-]+)(?: \(>= ([^)]+)\))?", wanted.split("|")[0])
        yield part(match[1], "DYNAMIC_LINK", match[2] or "")


def parts(package, arch, programs):
    if package == "pirvs":
        found = [*dynamic(programs), *(part(name, "STATIC_LINK") for name in HEADERS)]
    else:
        found = [part(name, "STATIC_LINK") for name in STATIC[arch]]
    return [*found, part(COMPILER[arch], "BUILD_TOOL_OF")]


def spdx_id(name):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def document(path, package, version, time, built_of):
    """The SPDX document of one package file."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    ours = {"name": package, "SPDXID": spdx_id(package), "versionInfo": version,
            "packageFileName": path.name, "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False, "licenseConcluded": "NOASSERTION",
            "licenseDeclared": "NOASSERTION", "copyrightText": "NOASSERTION",
            "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]}
    others = [{"name": found.name, "SPDXID": spdx_id("deb-" + found.name),
               "versionInfo": found.version, "downloadLocation": "NOASSERTION",
               "filesAnalyzed": False, "licenseConcluded": "NOASSERTION",
               "licenseDeclared": "NOASSERTION", "copyrightText": "NOASSERTION",
               "sourceInfo": f"Debian source {found.source} {found.source_version}",
               "externalRefs": [{
                   "referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                   "referenceLocator": f"pkg:deb/debian/{found.name.replace('+', '%2B')}"
                                       f"@{found.version.replace('+', '%2B')}"}]}
              for found in built_of]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                  "relatedSpdxElement": ours["SPDXID"]}]
    for found in built_of:
        ends = [ours["SPDXID"], spdx_id("deb-" + found.name)]
        if found.how == "BUILD_TOOL_OF":
            ends.reverse()
        relations.append({"spdxElementId": ends[0], "relationshipType": found.how,
                          "relatedSpdxElement": ends[1]})
    created = datetime.fromtimestamp(time, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    return json.dumps({
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": path.stem, "documentNamespace": f"https://spdx.org/spdxdocs/{path.stem}-{digest}",
        "creationInfo": {"created": created, "creators": ["Tool: pirvs-tools-deb-build"]},
        "packages": [ours, *others], "relationships": relations}, indent=1) + "\n"
