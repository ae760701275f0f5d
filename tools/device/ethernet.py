"""A peer of a machine in QEMU on one Ethernet link, made of frames: scans ports, asks for an
address and for a name, without any network of this machine's.
"""
import select
import socket
import struct
import time

OUR_MAC = bytes.fromhex("525400000001")
BROADCAST = b"\xff" * 6
ALL_TCP = range(1, 65536)
WINDOW = 200  # SYNs that are on their way; what is lost is sent again
SILENT_ROUNDS = 2
SYN, ACK, RST = 2, 16, 4


def checksum(data):
    if len(data) % 2:
        data += b"\0"
    total = sum(struct.unpack(f">{len(data) // 2}H", data))
    total = (total & 0xffff) + (total >> 16)
    return ~(total + (total >> 16)) & 0xffff


def address(text):
    return socket.inet_aton(text)


def peer_of(target):
    """Our address beside the other one."""
    return target.rsplit(".", 1)[0] + ".2"


class Link:
    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.mac, self.ours = None, None

    def options(self, name, mac):
        self.mac = bytes.fromhex(mac.replace(":", ""))
        here = self.socket.getsockname()[1]
        return ["-netdev", f"socket,id={name},udp=127.0.0.1:{here},"
                f"localaddr=127.0.0.1:{self.port}",
                "-device", f"virtio-net-pci,netdev={name},mac={mac},romfile="]

    # ---- frames ----------------------------------------------------------------------------------

    def send(self, kind, payload, to=None):
        frame = (to or self.mac) + OUR_MAC + struct.pack(">H", kind) + payload
        self.socket.sendto(frame.ljust(60, b"\0"), ("127.0.0.1", self.port))

    def send_ip(self, protocol, source, target, payload, to=None):
        head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(payload), 0, 0, 64, protocol, 0)
        head += address(source) + address(target)
        head = head[:10] + struct.pack(">H", checksum(head)) + head[12:]
        self.send(0x0800, head + payload, to)

    def send_udp(self, source, target, ports, payload, to=None):
        self.send_ip(17, source, target,
                     struct.pack(">HHHH", *ports, 8 + len(payload), 0) + payload, to)

    def receive(self, wait_s):
        """(protocol, source, payload) of IPv4 frames; who asks for our MAC is answered."""
        end = time.monotonic() + wait_s
        while select.select([self.socket], [], [], max(0, end - time.monotonic()))[0]:
            frame = self.socket.recv(4096)
            kind = struct.unpack(">H", frame[12:14])[0]
            if kind == 0x0806 and frame[20:22] == b"\0\1" and frame[38:42] == self.ours:
                self.send(0x0806, frame[14:20] + b"\0\2" + OUR_MAC + self.ours + frame[22:32])
            if kind == 0x0800:
                packet = frame[14:14 + struct.unpack(">H", frame[16:18])[0]]
                length = (packet[0] & 15) * 4
                yield packet[9], socket.inet_ntoa(packet[12:16]), packet[length:]

    # ---- questions -------------------------------------------------------------------------------

    def syn(self, source, target, port):
        head = struct.pack(">HHIIBBHHH", 40000, port, 1, 0, 5 << 4, SYN, 1024, 0, 0)
        pseudo = address(source) + address(target) + struct.pack(">BBH", 0, 6, len(head))
        head = head[:16] + struct.pack(">H", checksum(pseudo + head)) + head[18:]
        self.send_ip(6, source, target, head)

    def scan(self, target, ports=ALL_TCP):
        """Which TCP ports are open, and how many answered at all."""
        source = socket.inet_ntoa(self.ours) if self.ours else peer_of(target)
        self.ours = address(source)
        unanswered, is_open = set(ports), []
        silent = 0  # rounds without an answer: nobody is there
        while unanswered and silent < SILENT_ROUNDS:
            before = len(unanswered)
            for sent, port in enumerate(sorted(unanswered), 1):
                self.syn(source, target, port)
                if sent % WINDOW == 0:
                    self._collect(target, unanswered, is_open, 0.02)
            self._collect(target, unanswered, is_open, 1)
            silent = silent + 1 if len(unanswered) == before else 0
        return {"open": sorted(is_open), "answers": len(ports) - len(unanswered)}

    def _collect(self, target, unanswered, is_open, wait_s):
        for protocol, source, payload in self.receive(wait_s):
            if protocol != 6 or source != target:
                continue
            port, flags = struct.unpack(">H", payload[:2])[0], payload[13]
            if flags & SYN and flags & ACK and port in unanswered:
                is_open.append(port)
            unanswered.discard(port)

    def dhcp(self, tries=3):
        """The address that a PC is offered, or None."""
        discover = struct.pack(">BBBBIHH", 1, 1, 6, 0, 0x1234, 0, 0x8000) + bytes(16) + OUR_MAC
        discover = discover.ljust(236, b"\0") + bytes.fromhex("63825363" "350101" "ff")
        for _ in range(tries):
            self.send_udp("0.0.0.0", "255.255.255.255", (68, 67), discover, BROADCAST)
            for protocol, _, payload in self.receive(1):
                if protocol == 17 and payload[:4] == struct.pack(">HH", 67, 68):
                    return socket.inet_ntoa(payload[8 + 16:8 + 20])
        return None

    def mdns(self, name, tries=3):
        """The address of a name, or None."""
        labels = b"".join(bytes([len(part)]) + part.encode() for part in name.split("."))
        question = struct.pack(">6H", 0, 0, 1, 0, 0, 0) + labels + b"\0" + struct.pack(">HH", 1, 1)
        ours = socket.inet_ntoa(self.ours)
        for _ in range(tries):
            self.send_udp(ours, "224.0.0.251", (5353, 5353), question,
                          bytes.fromhex("01005e0000fb"))
            for protocol, _, payload in self.receive(1):
                found = payload.find(labels)
                if protocol == 17 and payload[:2] == b"\x14\xe9" and payload[8 + 2] & 0x80 \
                        and found >= 0:
                    return socket.inet_ntoa(payload[-4:])
        return None

    def ping(self, target):
        echo = struct.pack(">BBHHH", 8, 0, 0, 7, 1)
        echo = echo[:2] + struct.pack(">H", checksum(echo)) + echo[4:]
        for _ in range(2):
            self.send_ip(1, socket.inet_ntoa(self.ours), target, echo)
            for protocol, source, payload in self.receive(1):
                if protocol == 1 and source == target and payload[0] == 0:
                    return True
        return False
