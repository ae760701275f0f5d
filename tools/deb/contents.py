"""What lies in our packages beside programs, man pages and completion."""

from pathlib import Path

MAINTAINER = "PIRVS maintainers <maintainers@pirvs.invalid>"
# What lintian finds and we mean: one static file runs on any Linux, whatever libraries it has.
MEANT = ("statically-linked-binary", "embedded-library")
PROGRAMS = {"pirvs": ("pirvs",), "pirvsd": ("pirvsd", "pirvs-usb"), "libpirvs0": (),
            "libpirvs-dev": ()}
LIBRARY = "libpirvs.so.0"  # of libpirvs0
LIBRARIES = {"amd64": "usr/lib/x86_64-linux-gnu", "arm64": "usr/lib/aarch64-linux-gnu"}
SECTIONS = {"pirvs": "science", "pirvsd": "electronics", "libpirvs0": "libs",
            "libpirvs-dev": "libdevel"}
IMAGE = "board/ironsides/image/root"
INTERFACE = "board/library"

ABOUT = {
    "pirvs": """visual-inertial SLAM on recordings, and its tools
 Where a stereo camera and an IMU went: pirvs runs recordings (EuRoC folders,
 ROS bags, MCAP), judges them, draws simulated ones, and listens to devices.""",
    "pirvsd": """visual-inertial SLAM live: a stereo camera and an IMU as a pose sensor
 Tracks two cameras of V4L2 and an IMU of IIO, and gives out poses with their
 uncertainty, as lines, as datagrams, by USB and to autopilots.""",
    "libpirvs0": """visual-inertial SLAM for programs: shared library
 A program feeds images of one or two cameras and samples of an IMU, and gets
 poses with their uncertainty.""",
    "libpirvs-dev": """visual-inertial SLAM for programs: header and examples
 pirvs.h, and programs in C, C++ and Python that read a recording.""",
}

PKG_CONFIG = """libdir=/{folder}
includedir=/usr/include
Name: pirvs
Description: visual-inertial SLAM
Version: {version}
Libs: -L${{libdir}} -lpirvs
Cflags: -I${{includedir}}
"""

# The card's units, as a distribution wants them: (what stands there, what stands here).
UNITS = {
    "pirvsd.service": (
        ("RequiresMountsFor=/config\n",
         "Documentation=man:pirvsd(1)\n"
         "# Without a calibration there is nothing to track, and no reason to fail.\n"
         "ConditionPathExists=/etc/pirvs/calibration.cfg\n"),
        ("/config/device.cfg", "/etc/pirvs/pirvsd.cfg"),
        ("ReadWritePaths=-/recordings\n", "StateDirectory=pirvs\n"),
    ),
    "pirvs-usb.service": (
        ("RequiresMountsFor=/config /sys/kernel/config\n",
         "Documentation=man:pirvs-usb(1)\nRequiresMountsFor=/sys/kernel/config\n"),
        ("ExecStartPre=-modprobe", "ExecStartPre=-/sbin/modprobe"),
        ("/config/device.cfg", "/etc/pirvs/pirvsd.cfg"),
    ),
}


def unit(name, root):
    text = (root / IMAGE / "lib/systemd/system" / name).read_text()
    for before, after in UNITS[name]:
        if before not in text:
            raise SystemExit(f"deb: {name} of the card has no {before!r} any more")
        text = text.replace(before, after)
    return text


def development(root, arch, version):
    """Of libpirvs-dev, but for the link."""
    folder = LIBRARIES[arch]
    examples = sorted((root / INTERFACE / "examples").iterdir())
    return {
        "usr/include/pirvs.h": (root / INTERFACE / "pirvs.h").read_text(),
        f"{folder}/pkgconfig/pirvs.pc": PKG_CONFIG.format(folder=folder, version=version),
        **{f"usr/share/doc/libpirvs-dev/examples/{path.name}": path.read_text()
           for path in examples},
    }


def files(package, root):
    """{path: content}"""
    if package != "pirvsd":
        return {}
    here = Path(__file__).resolve().parent
    return {
        "usr/share/lintian/overrides/pirvsd": "".join(f"pirvsd: {tag} *\n" for tag in MEANT),
        "etc/pirvs/pirvsd.cfg": (here / "pirvsd.cfg").read_text(),
        "lib/udev/rules.d/60-pirvsd.rules": (here / "60-pirvsd.rules").read_text(),
        **{f"lib/systemd/system/{name}": unit(name, root) for name in UNITS},
    }


def control(package, arch, version, size_kib, built_of):
    needs = [f"{part.name} (>= {part.least})" if part.least else part.name
             for part in built_of if part.how == "DYNAMIC_LINK"]
    static = [f"{part.source} (= {part.source_version})" for part in built_of
              if part.how == "STATIC_LINK"]
    if package == "libpirvs-dev":
        needs.append(f"libpirvs0 (= {version})")
    fields = {
        "Package": package, "Version": version, "Architecture": arch,
        "Maintainer": MAINTAINER, "Installed-Size": str(size_kib),
        "Depends": ", ".join(needs),
        "Recommends": "kmod, udev" if package == "pirvsd" else "",
        "Multi-Arch": "same" if package.startswith("lib") else "",
        "Built-Using": ", ".join(sorted(set(static))),
        "Section": SECTIONS[package], "Priority": "optional",
        "Description": ABOUT[package],
    }
    return "".join(f"{name}: {value}\n" for name, value in fields.items() if value)
