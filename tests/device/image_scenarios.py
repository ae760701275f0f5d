#!/usr/bin/env python3
"""What a card of a device under Linux must do, in QEMU, through U-Boot: image_test.cc runs these.

Usage: tests/device/image_scenarios.py SCENARIO --build DIR --out DIR
SCENARIO: boot, update, failures, cuts, ports. OUT keeps the consoles. Prints what was measured and
each thing that is not as it must be. Exit status: 0 all is well, 1 not.
"""
import argparse
import hashlib
import os
import random
import re
import resource
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tools/device"), str(ROOT / "tools/image")]

import card
import ethernet
import layout

MIB = 1 << 20
CARD_BYTES = 1 << 30  # larger than the image: it has something to grow into
CONTENT = ROOT / "board/ironsides/image"
GUEST = ROOT / "tests/device/guest"
TIME = "1700000000"
COMPATIBLE = "pirvs-ironsides-rock-pi-4-rk3399"
BOOT_S_MAX = 240  # of this machine, which others load
USB_MAC, ETH_MAC = "52:54:00:00:07:01", "52:54:00:00:07:02"
UBOOT_DELAY_S = 2  # that a test skips by a key
FIRST_POSE_S_MAX = 10
BOOTS_MAX = 5


class Test:
    """One scenario's folders, findings and helpers."""

    def __init__(self, options):
        self.build, self.out, self.findings = options.build, options.out, []
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir(parents=True)
        self.slot = self.build / "ironsides/slot"
        self.log = open(self.out / "console", "w", encoding="utf-8")

    def expect(self, true, what):
        if not true:
            self.findings.append(what)
            print(f"WRONG: {what}", flush=True)
        return bool(true)

    def run(self, *command, **options):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False,
                              cwd=ROOT, **options)
        if done.returncode:
            raise RuntimeError(f"{command[0]} failed: {done.stderr}{done.stdout}")

    def copy_card(self, **files):
        """The image as it was built, with files in the partition that a person edits, the
        calibration among them."""
        files["calibration__cfg"] = (self.build / "test/image.cfg").read_bytes()
        path = self.out / "card.img"
        shutil.copy(self.build / "ironsides/card.img", path)
        os.truncate(path, CARD_BYTES)
        offset = partition(path, "PIRVS")[0] * layout.SECTOR
        for name, content in files.items():
            (self.out / "file").write_bytes(content)
            self.run("mcopy", "-o", "-i", f"{path}@@{offset}", self.out / "file",
                     "::" + name.replace("__", "."))
        return path

    def overlay(self, *units, cameras=False, **files):
        """A disk of what the tests add to a device: tests/device/guest/image and more. Without
        cameras pirvsd is well as soon as it runs."""
        folder, path = self.out / "overlay", self.out / "overlay.squashfs"
        shutil.copytree(GUEST / "image", folder, symlinks=True)
        system = folder / "lib/systemd/system"
        wants = system / "multi-user.target.wants"
        wants.mkdir()
        if not cameras:
            (system / "pirvsd.service.d").mkdir()
            (system / "pirvsd.service.d/test.conf").write_text(
                "[Service]\nType=simple\nWatchdogSec=0\n")
        for unit in units:
            (wants / unit).symlink_to(f"../{unit}")
        for name, source in files.items():
            shutil.copy(source, folder / "usr/lib/test" / name.replace("__", "."))
        self.run("mksquashfs", folder, path, "-comp", "zstd", "-Xcompression-level", "1", "-quiet",
                 "-no-progress", "-all-root", "-noappend")
        return path

    def start(self, image, disks, devices=(), counted=False, extra=""):
        """The overlay is the last of the disks, which Linux counts from the end."""
        last = "vd" + "abcdef"[len(disks)]
        return card.Card(image, f"pirvs.overlay={last} {extra}", [disks[-1], *disks[:-1]], devices,
                         counted, self.log)

    def root(self, version, pirvsd=None):
        """The image's root under another version, or with another pirvsd."""
        path, bin_ = self.out / f"{version}.squashfs", self.slot / "bin"
        programs = {name: bin_ / name for name in ("pirvs-usb", "pirvs-card", "pirvs-receive")}
        programs["pirvsd"] = pirvsd or bin_ / "pirvsd"
        self.run("tools/image/build_root", "--debian", self.build / "debian/ironsides.tar",
                 "--kernel", self.build / "device", "--content", CONTENT, "--version", version,
                 "--compatible", COMPATIBLE, "--time", TIME, "--level", "1", "--out", path,
                 f"/etc/rauc/keyring.pem={self.build}/ironsides/keys/cert.pem",
                 *(f"/usr/bin/{name}={file}" for name, file in programs.items()))
        return path

    def bundle(self, version, root=None, init=None, keys=None):
        """An update with the image's own kernel and root but for what is given."""
        folder, keys = self.out / f"slot-{version}", keys or self.build / "ironsides/keys"
        folder.mkdir()
        (folder / "root.squashfs").symlink_to(root or self.slot / "root.squashfs")
        if init:
            self.kernel(folder / "kernel.fit", init)
        else:
            (folder / "kernel.fit").symlink_to(self.slot / "kernel.fit")
        self.run("tools/image/build_bundle", "--slot", folder, "--compatible", COMPATIBLE,
                 "--version", version, "--key", keys / "key.pem", "--cert", keys / "cert.pem",
                 "--out", self.out / f"{version}.raucb")
        return self.out / f"{version}.raucb"

    def kernel(self, out, init):
        """Beside what the image's own has, its initramfs knows the slots' state."""
        path = self.out / "init"
        path.write_text(init)
        self.run("tools/image/build_kernel", "--kernel", self.build / "device", "--content",
                 CONTENT, "--dtb", "rk3399-rock-pi-4b.dtb", "--level", "1",
                 "--init", path, "--out", out,
                 f"/bin/pirvs-card={self.slot}/bin/pirvs-card")

    def pirvs(self, *words):
        return subprocess.run([self.build / "host/pirvs", *map(str, words)], capture_output=True,
                              text=True, check=False)


def partition(image, name):
    return next(entry for entry in layout.gpt_partitions(image, 1) if entry[2] == name)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def usb_link(*forwards):
    """The USB link with this machine as the PC at 192.168.7.2; (here, there) ports."""
    words = "".join(f",hostfwd=tcp:127.0.0.1:{here}-192.168.7.1:{there}"
                    for here, there in forwards)
    return ["-netdev", "user,id=usb,net=192.168.7.0/24,host=192.168.7.2,dns=192.168.7.3,"
            f"restrict=on{words}", "-device", f"virtio-net-pci,netdev=usb,mac={USB_MAC},romfile="]


# ---- boot ---------------------------------------------------------------------------------------


def boot(test):
    """From power through U-Boot to the first pose, nobody logging in."""
    settings = (CONTENT / "config/device.cfg").read_bytes().replace(b"192.168.7.2", b"127.0.0.1")
    (test.out / "guest").write_text((test.build / "test/image.guest").read_text())
    modules = test.build / "device/modules"
    overlay = test.overlay("test-sensors.service", "test-feeder.service", cameras=True,
                           guest=test.out / "guest",
                           feeder=test.build / "device/feeder",
                           first_pose=test.build / "device/first_pose",
                           test_camera__ko=modules / "test_camera.ko",
                           test_gpio__ko=modules / "test_gpio.ko",
                           test_imu__ko=modules / "test_imu.ko")
    for attempt in range(BOOTS_MAX):
        image = test.copy_card(device__cfg=settings)
        took_s = boot_once(test, image, overlay)
        # The guest's clock leaps on while it waits for this machine's disk: that only ever adds.
        if took_s is None or took_s < FIRST_POSE_S_MAX or attempt + 1 == BOOTS_MAX:
            break
        print("later than 10 s: again")
    if took_s is not None:
        test.expect(took_s < FIRST_POSE_S_MAX, "later than 10 s")


def boot_once(test, image, overlay):
    """Seconds of the guest from power to the first pose; None: there was none."""
    config = partition(image, "PIRVS")
    before = layout.read_at(image, config[0] * layout.SECTOR, 64 * MIB)
    with test.start(image, [(test.build / "test/image.pack", "recording"), (overlay, "overlay")],
                    counted=True, extra="systemd.journald.forward_to_console=1") as machine:
        came = machine.wait_for("first pose ", BOOT_S_MAX)
        wall_s = machine.seconds()
        came is not None and machine.wait_for("\n", 5, came)
    test.expect("login:" not in machine.console, "something asks for a login")
    if not test.expect(came is not None, "no pose; see the console"):
        return None
    told = re.search(r"first pose ([\d.]+) s after power, ([\d.]+) s after", machine.console[came:])
    power_s, kernel_s = map(float, told.groups())
    took_s = power_s + UBOOT_DELAY_S
    print(f"first pose {took_s:.1f} s after power, of which {UBOOT_DELAY_S} s "
          f"are U-Boot's countdown and {kernel_s:.1f} s since the kernel's start (guest); "
          f"{wall_s:.0f} s of this machine")
    test.expect(partition(image, "recordings")[1] > (CARD_BYTES - 2 * MIB) // layout.SECTOR,
                "the recordings did not grow")
    test.expect(layout.read_at(image, config[0] * layout.SECTOR, 64 * MIB) == before,
                "the device wrote /config")
    return took_s


# ---- update -------------------------------------------------------------------------------------


class Device:
    """A running card on the USB link."""

    def __init__(self, test, image):
        self.test, self.port, self.ssh = test, free_port(), free_port()
        overlay = test.overlay()
        self.machine = test.start(image, [(overlay, "overlay")],
                                  usb_link((self.port, 4711), (self.ssh, 22)),
                                  extra="systemd.journald.forward_to_console=1")
        self.host = f"127.0.0.1:{self.port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.machine.cut()

    def wait_until_it_answers(self):
        end = time.monotonic() + BOOT_S_MAX
        while time.monotonic() < end:
            asked = self.test.pirvs("update", self.host)
            if asked.returncode == 0:
                return asked.stdout.strip()
            time.sleep(2)
        return f"nothing: {asked.stderr.strip()}"

    def update(self, bundle):
        return self.test.pirvs("update", self.host, bundle, "--wait", 2 * BOOT_S_MAX)

    def refuses(self, bundle, why):
        done = self.update(bundle)
        print(f"{bundle.name}: {done.stderr.strip()}")
        self.test.expect(done.returncode == 1 and re.search(why, done.stderr),
                         f"{bundle.name} was not refused: {done}")


def other_keys(test):
    folder = test.out / "other"
    folder.mkdir()
    test.run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
             "-noenc", "-days", "36500", "-subj", "/CN=another", "-keyout", folder / "key.pem",
             "-out", folder / "cert.pem")
    return folder


def half_a_transfer(device):
    """A PC that goes away in the middle."""
    with socket.create_connection(("127.0.0.1", device.port), 10) as link:
        link.settimeout(60)
        link.sendall(b"pirvs 1 update 1000000\n")
        ready = link.recv(100)
        link.sendall(bytes(1000))
        link.shutdown(socket.SHUT_WR)
        answer = link.recv(200)
    return ready == b"ready\n" and b"refused the connection ended" in answer


def check_ssh(device, key):
    """In with the key, and with nothing else."""
    words = ["ssh", "-p", device.ssh, "-o", "StrictHostKeyChecking=no", "-o", "LogLevel=ERROR",
             "-o", "UserKnownHostsFile=/dev/null", "-o", "BatchMode=yes",
             "-o", "IdentityAgent=none", "-o", "ConnectTimeout=60", "-F", "none"]

    def ssh(*more):
        return subprocess.run([*map(str, words), *map(str, more)], capture_output=True, text=True,
                              check=False, timeout=120)

    inside = ssh("-i", key, "root@127.0.0.1", "id -u; cat /etc/os-release")
    device.test.expect(inside.returncode == 0 and inside.stdout.startswith("0\n"),
                       f"no SSH with the key: {inside}")
    outside = ssh("-o", "PubkeyAuthentication=no", "root@127.0.0.1", "true")
    device.test.expect("Permission denied (publickey)" in outside.stderr,
                       f"SSH without a key: {outside}")
    print(f"SSH: with the key in, else: {outside.stderr.strip()}")


def update(test):
    """To another version; what is not signed by us, or not whole, is refused."""
    test.run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", test.out / "key")
    image = test.copy_card(authorized_keys=(test.out / "key.pub").read_bytes())
    good = test.bundle("test-b", root=test.root("test-b"))
    stranger = test.bundle("test-stranger", keys=other_keys(test))
    truncated = test.out / "truncated.raucb"
    truncated.write_bytes(good.read_bytes()[:-1_000_000])
    with Device(test, image) as device:
        print(device.wait_until_it_answers())
        device.refuses(stranger, "signature|certificate")
        device.refuses(truncated, "signature|bundle")
        test.expect(half_a_transfer(device), "half a transfer was not refused")
        check_ssh(device, test.out / "key")
        begin = time.monotonic()
        done = device.update(good)
        print(f"{done.stdout}update: {time.monotonic() - begin:.0f} s of this machine")
        test.expect(done.returncode == 0 and "version test-b runs and is good, slot b"
                    in done.stdout, f"the update failed: {done}")


# How a version fails, what its initramfs does for that, and what the console tells of no other.
FAILS = {
    "panics": ("echo c > /proc/sysrq-trigger", "Kernel panic"),
    "hangs": ("while :; do :; done", None),
    "ends": (":", "pirvsd.service: Failed with result"),
}


def failing(kinds):
    """The initramfs of a version whose first start fails as the first of `kinds` says, and so on;
    one that ends comes as far as its pirvsd. The watchdog runs by then."""
    cases = "".join(f"  *left={left}*) echo '<0>test: {kind}' > /dev/kmsg; {FAILS[kind][0]} ;;\n"
                    for left, kind in zip((2, 1, 0), kinds))
    last = "for folder in dev proc sys"
    before, after = (CONTENT / "init").read_text().split(last)
    return f"{before}case $(pirvs-card --card /dev/vda get) in\n{cases}esac\n{last}{after}"


def failures(test):
    """A version whose three starts panic, hang, and have a pirvsd that fails: back on the old one.
    FAILURES=each: three versions, each of which fails in one way."""
    (test.out / "fails").write_text("#!/bin/sh\nexit 1\n")
    (test.out / "fails").chmod(0o755)
    image = test.copy_card()
    each = os.environ.get("FAILURES") == "each"
    plans = [(kind,) * 3 for kind in FAILS] if each else [tuple(FAILS)]
    with Device(test, image) as device:
        first = device.wait_until_it_answers()
        print(first)
        for number, kinds in enumerate(plans):
            version = f"test-fails-{number}"
            bundle = test.bundle(version, root=test.root(version, test.out / "fails"),
                                 init=failing(kinds))
            begin, said = time.monotonic(), len(device.machine.console)
            done = device.update(bundle)
            console = device.machine.console[said:]
            print(f"{bundle.name}: {', '.join(kinds)}: {time.monotonic() - begin:.0f} s of this "
                  f"machine: {done.stderr.strip()}")
            test.expect(done.returncode == 1 and "the new version failed" in done.stderr,
                        f"{bundle.name}: {done}")
            left = re.findall(r"trial=b left=(\d), starting (.)", console)
            test.expect(left == [("2", "b"), ("1", "b"), ("0", "b"), ("0", "a")],
                        f"{bundle.name}: other starts: {left}")
            for kind, start in zip(kinds, console.split(", starting b")[1:]):
                start = start.split("U-Boot 20")[0]
                told = [name for name, (_, words) in FAILS.items() if words and words in start]
                test.expect(f"test: {kind}" in start
                            and told == [kind] * (FAILS[kind][1] is not None),
                            f"{bundle.name}: a start that {kind} was seen to: {told}")
            test.expect(device.wait_until_it_answers() == first, "another version than before")


# ---- cuts ---------------------------------------------------------------------------------------


# After which line of the console, whether that comes before the slot was found complete, and up to
# how many seconds later the power is cut.
MOMENTS = (("U-Boot 20", True, 3), ("PIRVS: state", True, 2), ("Starting kernel", True, 4),
           ("GOOD version", False, 0.5), ("UPDATE", False, 0.5), ("UPDATE", False, 2),
           ("ARMED", False, 0.3), ("left=2, starting", False, 0.3),
           ("left=2, starting", False, 6))
LAST = ("GOOD version", False, 0)


def small_root(path, version, size):
    """What cut_init calls a root: version, size and SHA-256 of the rest."""
    rest = random.Random(version).randbytes(size)
    head = f"{version}\n{len(rest)}\n{hashlib.sha256(rest).hexdigest()}\n".encode()
    path.write_bytes(head.ljust(4096, b"\0") + rest)


def cuts(test):
    """Power cuts at random moments of updates, one after the other on one small card: the same
    U-Boot, boot script, state, kernel and steps of an update; the root is 4 MiB and is checked."""
    count = int(os.environ.get("CUTS", "20"))
    seed = int(os.environ.get("SEED", "1"))
    chance = random.Random(seed)
    slot = test.out / "slot"
    slot.mkdir()
    test.kernel(slot / "kernel.fit", (GUEST / "cut_init").read_text())
    small_root(slot / "root.squashfs", 1, 4 * MIB)
    image, offered = test.out / "card.img", test.out / "offered"
    test.run("tools/image/build_card", "--content", CONTENT, "--slot", slot, "--time", TIME,
             "--out", image)
    config = partition(image, "PIRVS")
    before = layout.read_at(image, config[0] * layout.SECTOR, 64 * MIB)
    version, begin, moments = 1, time.monotonic(), {}
    for number in range(count + 1):
        small_root(offered, number + 2, 4 * MIB)  # newer than any there is
        mark, early, late_s = chance.choice(MOMENTS) if number < count else LAST
        with card.Card(image, "", [(offered, "offered")], log=test.log) as machine:
            if not early:
                version = verified(test, machine, version)
            if test.expect(machine.wait_for(mark, BOOT_S_MAX) is not None, f"no {mark}"):
                time.sleep(chance.uniform(0, late_s))
            moment = where(machine.console)
        if number < count:
            moments[moment] = moments.get(moment, 0) + 1
        if test.findings:
            break
    test.expect(layout.read_at(image, config[0] * layout.SECTOR, 64 * MIB) == before,
                "the configuration is another")
    print(f"{count} power cuts (seed {seed}), at last version {version}; cut in: " +
          ", ".join(f"{name} {times}" for name, times in sorted(moments.items())) +
          f"; {time.monotonic() - begin:.0f} s of this machine")


def verified(test, machine, version):
    """The version that starts, which must be complete, and none before the last good one."""
    came = machine.wait_for("GOOD version", BOOT_S_MAX)
    found = re.search(r"COMPLETE slot (.) version (\d+) state (.*)\n", machine.console)
    if not test.expect(came is not None and found, "a cut that it did not come back from"):
        print(machine.console[-2000:])
        return version
    now = int(found[2])
    test.expect(now >= version, f"version {now} after {version}")
    return now


def where(console):
    """In what the power was cut."""
    marks = (("Starting kernel", "kernel"), ("COMPLETE", "check"), ("GOOD", "after good"),
             ("UPDATE", "copy"), ("ARMED", "armed"), ("IDLE", "idle"))
    last = max((console.rfind(mark), name) for mark, name in marks)
    if console.rfind("U-Boot 20") > last[0]:
        return "U-Boot"
    return last[1] if last[0] >= 0 else "U-Boot"


# ---- ports --------------------------------------------------------------------------------------


def ports(test):
    """What answers on the USB link, and that nothing does on another."""
    image = test.copy_card()
    usb, eth = ethernet.Link(), ethernet.Link()
    devices = [*usb.options("usb", USB_MAC), *eth.options("eth", ETH_MAC)]
    overlay = test.overlay("test-sockets.service")
    with test.start(image, [(overlay, "overlay")], devices) as machine:
        began = machine.wait_for("test: sockets end", BOOT_S_MAX)
        test.expect(began is not None, "it did not start")
        begin = time.monotonic()
        results = {}
        threads = [threading.Thread(target=lambda n=name, l=link, a=address: results.update(
            {n: l.scan(a)})) for name, link, address in (
                ("usb", usb, "192.168.7.1"), ("eth", eth, "10.0.0.1"),)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        print(f"USB link: TCP {results['usb']}; second interface: TCP {results['eth']}; "
              f"{time.monotonic() - begin:.0f} s of this machine")
        test.expect(results["usb"] == {"open": [4711], "answers": 65535}, "other ports on the USB")
        test.expect(results["eth"] == {"open": [], "answers": 0}, "the second interface answers")
        test.expect(eth.scan("192.168.7.1", (22, 53, 4711, 5353)) == {"open": [], "answers": 0},
                    "the USB link's address answers on the second interface")
        offer = usb.dhcp()
        print(f"USB link: DHCP offers {offer}, mDNS says {usb.mdns('pirvs.local')}, ping "
              f"{usb.ping('192.168.7.1')}")
        test.expect(offer and offer.startswith("192.168.7.") and int(offer.split(".")[3]) >= 2,
                    f"DHCP offers {offer}")
        test.expect(usb.mdns("pirvs.local") == "192.168.7.1", "no mDNS on the USB link")
        test.expect(eth.dhcp() is None, "DHCP on the second interface")
        test.expect(eth.mdns("pirvs.local") is None, "mDNS on the second interface")
        test.expect(not eth.ping("10.0.0.1"), "the second interface answers to a ping")
    listed = sorted(set(re.findall(r"test: socket (.*)", machine.console)))
    print("sockets of the device: " + ", ".join(listed))
    known = {"tcp 192.168.7.1:4711", "udp 0.0.0.0:5353", "udp 0.0.0.0:67", "udp6 :::5353"}
    # From one of these, which the kernel chooses, pirvsd sends its poses.
    others = [name for name in listed if name not in known
              and not re.fullmatch(r"udp 0\.0\.0\.0:(3[2-9]|4\d|5\d|60)\d{3}", name)]
    test.expect(not others and len(listed) - len(known) <= 1,
                f"sockets that docs/device.md does not list: {listed}")


def main():
    scenarios = {f.__name__: f for f in (boot, update, failures, cuts, ports)}
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("scenario", choices=scenarios)
    parser.add_argument("--build", type=Path, default=Path("build"))
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.build, options.out = options.build.resolve(), options.out.resolve()
    test = Test(options)
    begin = time.monotonic()
    scenarios[options.scenario](test)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{options.scenario}: {time.monotonic() - begin:.0f} s of this machine, "
          f"{used.ru_utime + used.ru_stime:.0f} s of its processors", flush=True)
    if not test.findings:
        for path in test.out.glob("*"):
            if path.name != "console":
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    return 1 if test.findings else 0


if __name__ == "__main__":
    sys.exit(main())
