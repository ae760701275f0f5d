"""A card in QEMU's `virt`, started through Debian's U-Boot as on a board: for tests.

The card is a copy of the image, as large as a real one, so its own bytes are those that were built.
What a test adds lies on disks beside it (pirvs.overlay=, board/ironsides/image/init), or in the
FAT partition that a person edits.
"""
import ctypes
import os
import signal
import subprocess
import threading
import time

UBOOT = "/usr/lib/u-boot/qemu_arm64/u-boot.bin"
MACHINE = ["-M", "virt,gic-version=3,acpi=off", "-cpu", "cortex-a72", "-m", "1G",
           "-display", "none", "-monitor", "none", "-serial", "stdio", "-bios", UBOOT,
           "-device", "i6300esb", "-watchdog-action", "reset"]
# One nanosecond an instruction; else two processors as fast as they go.
COUNTED = ["-smp", "1", "-icount", "shift=0,sleep=off"]
LOST_AT_RESET_MAX = 32  # characters, when U-Boot sets up its serial line
FREE = ["-smp", "2", "-accel", "tcg,thread=multi"]


def end_with_us():
    """The machine's power goes when this program does, whatever ends it."""
    set_parent_death_signal = 1
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)


class Card:
    """A running machine. `console` holds all that it has said."""

    def __init__(self, image, extra="", disks=(), devices=(), counted=False, log=None):
        command = ["qemu-system-aarch64", *MACHINE, *(COUNTED if counted else FREE)]
        # The last disk is U-Boot's first.
        for number, (path, serial) in enumerate(disks):
            command += ["-drive", f"if=none,format=raw,readonly=on,id=disk{number},file={path}",
                        "-device", f"virtio-blk-device,drive=disk{number},serial={serial}"]
        command += ["-drive", f"if=none,format=raw,cache=unsafe,id=card,file={image}",
                    "-device", "virtio-blk-device,drive=card",
                    *(devices or ("-nic", "none"))]
        self.extra, self.console, self.log = extra, "", log
        self._answered, self._typed_ahead = 0, counted
        self.begin = time.monotonic()
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, start_new_session=True,
                                        preexec_fn=end_with_us)
        self._ended = threading.Event()
        if counted:  # U-Boot must not count instructions while this machine is slow to answer
            self._type(" " * LOST_AT_RESET_MAX + self._command())
        threading.Thread(target=self._listen, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.cut()

    def cut(self):
        """As a power cut: at once."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def _type(self, text):
        try:
            self.process.stdin.write(text.encode())
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # its power was cut

    def _answer(self):
        """U-Boot's countdown is cut short, and it is told what the kernel is to be told."""
        tail = self.console[self._answered:]
        if self._typed_ahead:
            if "Starting kernel" in tail:
                self._typed_ahead, self._answered = False, len(self.console)
            return
        if "stop autoboot" in tail:
            self._answered = len(self.console)
            self._type(" ")
        elif "\n=> " in tail:
            self._answered = len(self.console)
            self._type(self._command())

    def _command(self):
        extra = f"setenv extra '{self.extra}'; " if self.extra else ""
        return extra + "run bootcmd_virtio0\r"

    def _listen(self):
        while chunk := os.read(self.process.stdout.fileno(), 1 << 16):
            text = chunk.decode(errors="replace").replace("\r", "")
            self.console += text
            if self.log:
                self.log.write(text)
                self.log.flush()
            self._answer()
        self._ended.set()

    def wait_for(self, text, limit_s, since=0):
        """Where the text begins; None if it did not come, or the machine ended."""
        end = time.monotonic() + limit_s
        while (at := self.console.find(text, since)) < 0:
            if time.monotonic() > end or self._ended.is_set():
                return None
            time.sleep(0.02)
        return at

    def seconds(self):
        return time.monotonic() - self.begin
