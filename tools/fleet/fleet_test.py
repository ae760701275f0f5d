"""A fleet at a real broker, where mosquitto is here; thinning, reading and counting without."""

import argparse
import contextlib
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
from importlib.machinery import SourceFileLoader
from pathlib import Path

import device

HERE = Path(__file__).resolve().parent
MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/bin:/usr/local/sbin")
LINE = "1.5 1 2 3 0 0 0 1 tracking 0.90"


def run_folder(folder):
    """Two seconds at 20 Hz."""
    rows = [f"{k * 50_000_000},tracking,{k},0,0,0,0,0,1,1.0" for k in range(40)]
    (Path(folder) / "state.csv").write_text(
        "#t_ns,health,px,py,pz,qx,qy,qz,qw,confidence\n" + "\n".join(rows) + "\n")
    return folder


def call(*words, **more):
    return subprocess.run([sys.executable, "-B", *words], capture_output=True, text=True,
                          timeout=120, **more)


class Words(unittest.TestCase):
    def test_lines_of_pirvsd(self):
        self.assertEqual(device.pose_of_line(LINE)["p"], [1, 2, 3])
        for line in ("", "# sync_in 1 0", "ok pose", LINE.replace("1.5", "x"), "1 2 3"):
            self.assertIsNone(device.pose_of_line(line))

    def test_addresses(self):
        self.assertEqual(device.address("a.b:99"), ("a.b", 99))
        self.assertEqual(device.address("a"), ("a", 1883))
        for text in ("a:", ":1", "a:x", "a:70000"):
            with self.assertRaises(ValueError):
                device.address(text)

    def test_thinned_to_the_rate_by_the_poses_own_time(self):
        sender = object.__new__(device.Device)
        sender.period_s, sender.next_s = 0.1, None
        times = [k * 0.005 for k in range(400)] + [k * 0.005 for k in range(400)]  # begins anew
        sent = sum(sender.due({"t": t}) for t in times)
        self.assertAlmostEqual(sent, 40, delta=1)

    def test_what_did_not_come_is_counted(self):
        fleet = SourceFileLoader("fleet", str(HERE / "fleet")).load_module()
        senders = [types.SimpleNamespace(number=10), types.SimpleNamespace(number=5)]
        listener = types.SimpleNamespace(numbers={"a": set(range(10)), "b": {0, 1, 4}}, twice=0,
                                         bytes=1300, delays=[0.001, 0.002])
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            status = fleet.tell(argparse.Namespace(qos=0, json=True), senders, listener, 10.0, 400)
        told = json.loads(out.getvalue())
        self.assertEqual((status, told["lost"], told["payload_bytes"]), (1, 2, 100))
        self.assertEqual(told["mqtt_bytes_per_second_device"], 200)

    def test_no_broker(self):
        for words in (["fleet", "RUN", "--broker", "127.0.0.1:1"],
                      ["publish", "--device", "a", "--broker", "127.0.0.1:1"]):
            with tempfile.TemporaryDirectory() as folder:
                run_folder(folder)
                words = [word.replace("RUN", folder) for word in words]
                done = call(str(HERE / words[0]), *words[1:], input="")
            self.assertEqual(done.returncode, 2)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)


@unittest.skipUnless(os.environ.get("PIRVS_NIGHTLY"), "for make nightly")
@unittest.skipUnless(MOSQUITTO, "no mosquitto here")
class AtABroker(unittest.TestCase):
    def test_fifty_replays(self):
        with tempfile.TemporaryDirectory() as folder:
            done = call(str(HERE / "fleet"), run_folder(folder), "--seconds", "4", "--qos", "1",
                        "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual((told["devices"], told["lost"], told["twice"]), (50, 0, 0))
        self.assertGreater(told["sent"], 50 * 8)
        self.assertGreater(told["payload_bytes"], 80)

    def test_live_lines_and_a_will(self):
        fleet = SourceFileLoader("fleet", str(HERE / "fleet")).load_module()
        lines = "\n".join(f"{k / 10} 1 2 3 0 0 0 1 tracking 0.90" for k in range(20)) + "\nwhat\n"
        with fleet.Broker() as broker:
            listener = fleet.Listener(broker, "pirvs")
            done = call(str(HERE / "publish"), "--device", "d", "--broker", "%s:%d" % broker,
                        input=lines)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("1 lines of standard input were no poses", done.stderr)
            self.assertIn("20 poses", done.stderr)
            for _ in range(100):
                if len(listener.numbers.get("d", ())) == 20 and not listener.online:
                    break
                fleet.time.sleep(0.1)
            self.assertEqual(listener.numbers["d"], set(range(20)))
            self.assertEqual(listener.online, set())
            listener.client.disconnect()
            listener.client.loop_stop()


if __name__ == "__main__":
    unittest.main()
