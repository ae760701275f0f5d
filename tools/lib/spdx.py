"""Bills of materials in SPDX 2.3: what something of ours is made of, Debian's packages."""

import collections
import hashlib
import json
import re
import subprocess
from datetime import datetime, timezone

# how: DYNAMIC_LINK, STATIC_LINK, BUILD_TOOL_OF or CONTAINS. least: the version a dynamic one must
# have.
Part = collections.namedtuple("Part", "name version source source_version how least")

NOTHING_SAID = {key: "NOASSERTION" for key in ("downloadLocation", "licenseConcluded",
                                               "licenseDeclared", "copyrightText")}


def installed(name, how, least=""):
    """A package of this machine."""
    shown = subprocess.run(
        ["dpkg-query", "-W", "-f",
         "${Version}\t${source:Package}\t${source:Version}\n", name],
        text=True, capture_output=True)
    if shown.returncode != 0:
        raise SystemExit(f"spdx: {name} is not installed: tools/setup/install")
    return Part(name, *shown.stdout.splitlines()[0].split("\t"), how, least)


def spdx_id(name):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def package_of(part):
    return {"name": part.name, "SPDXID": spdx_id("deb-" + part.name),
            "versionInfo": part.version, "filesAnalyzed": False, **NOTHING_SAID,
            "sourceInfo": f"Debian source {part.source} {part.source_version}",
            "externalRefs": [{
                "referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                "referenceLocator": f"pkg:deb/debian/{part.name.replace('+', '%2B')}"
                                    f"@{part.version.replace('+', '%2B')}"}]}


def document(path, name, version, time, parts, tool):
    """The text for one file of ours; the same input gives the same bytes."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    ours = {"name": name, "SPDXID": spdx_id(name), "versionInfo": version,
            "packageFileName": path.name, "filesAnalyzed": False, **NOTHING_SAID,
            "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]}
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                  "relatedSpdxElement": ours["SPDXID"]}]
    for part in parts:
        ends = [ours["SPDXID"], spdx_id("deb-" + part.name)]
        if part.how == "BUILD_TOOL_OF":
            ends.reverse()
        relations.append({"spdxElementId": ends[0], "relationshipType": part.how,
                          "relatedSpdxElement": ends[1]})
    created = datetime.fromtimestamp(time, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    return json.dumps({
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": path.stem, "documentNamespace": f"https://spdx.org/spdxdocs/{path.stem}-{digest}",
        "creationInfo": {"created": created, "creators": [f"Tool: {tool}"]},
        "packages": [ours, *map(package_of, parts)], "relationships": relations}, indent=1) + "\n"
