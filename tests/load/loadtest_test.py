#!/usr/bin/python3
"""Tests of `lodestream loadtest` with a server that is stopped for a second, and without a terminal: loadtest_test.py BIN_DIR
MODELS_DIR SOURCE_DIR"""
import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import tempfile
import time
import unittest

from daemon import BIN, STORE, Daemon

CAMERA = {"fov_y_deg": 45, "keys": [{"t": 0, "eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]},
                                    {"t": 1, "eye": [0, 0, 2], "target": [0, 0, 0], "up": [0, 1, 0]}]}
STILL_S, TEST_S = 1.0, 4
LIVE_LINE = re.compile(r" *(\d+) s: (\d+) clients, (\d+) blobs/s, \d+\.\d MB/s, visible requests: .+, 0 lost, 0 errors")


def lodestream(*arguments, **options):
    return subprocess.Popen([os.path.join(BIN, "lodestream"), *map(str, arguments)], stdout=subprocess.PIPE, text=True, **options)


class Latency(unittest.TestCase):
    def trace(self, url, folder):
        """Makes a trace of all blobs that a camera path requests, at a steady rate."""
        camera, trace = (os.path.join(folder, name) for name in ("camera.json", "trace.json"))
        with open(camera, "w") as file:
            json.dump(CAMERA, file)
        lodestream("replay", url, "--camera", camera, "--cache", "off", "--record", trace, "--json").communicate(timeout=300)
        with open(trace) as file:
            recorded = json.load(file)
        requests = recorded["requests"]
        for number, request in enumerate(requests):
            request["t"], request["class"] = number / len(requests), 0
        with open(trace, "w") as file:
            json.dump({**recorded, "duration_s": 1, "requests": requests}, file)
        return trace

    def test_is_measured_from_the_planned_time_of_a_request(self):
        with tempfile.TemporaryDirectory() as folder, Daemon(STORE) as daemon:
            url = f"lode://{daemon.address}/painted"
            test = lodestream("loadtest", url, "--trace", self.trace(url, folder), "--clients", 4, "--seconds", TEST_S,
                              "--decode-off", "--json")
            time.sleep(TEST_S / 2)
            daemon.process.send_signal(signal.SIGSTOP)
            time.sleep(STILL_S)
            daemon.process.send_signal(signal.SIGCONT)
            told = json.loads(test.communicate(timeout=300)[0])
        late = told["latency_ms"]["visible"]
        # A quarter of the requests fall into the second in which the server is stopped. Each is late by the rest of the second,
        # so a tenth of all requests is late by at least 0.6 s.
        self.assertGreater(late["count"], 100)
        self.assertGreater(late["p90"], 300)


def load(daemon, seconds, **options):
    """Runs clients that all start at once, so that they receive most bytes in the first second."""
    return lodestream("loadtest", f"lode://{daemon.address}/painted", "--clients", 4, "--seconds", seconds, "--ramp", 0, "--decode-off",
                      "--json", **options)


class LiveLines(unittest.TestCase):
    def test_report_every_second_on_a_terminal(self):
        terminal, end = pty.openpty()
        with Daemon(STORE) as daemon, open(terminal, "rb", buffering=0) as terminal:
            test = load(daemon, TEST_S, stderr=end)
            os.close(end)
            said = b""
            with contextlib.suppress(OSError):  # EIO: the other end is closed
                while some := terminal.read(4096):
                    said += some
            told = json.loads(test.communicate(timeout=300)[0])
        lines = [LIVE_LINE.fullmatch(line) for line in said.decode().splitlines()]
        self.assertNotIn(None, lines, said)
        self.assertEqual([int(line[1]) for line in lines], list(range(1, TEST_S)))
        self.assertEqual(int(lines[-1][2]), 4)
        self.assertGreater(sum(int(line[3]) for line in lines), 0)
        self.assertLessEqual(sum(int(line[3]) for line in lines), told["blobs"])

    def test_are_not_written_to_a_pipe(self):
        with Daemon(STORE) as daemon:
            self.assertEqual(load(daemon, 2, stderr=subprocess.PIPE).communicate(timeout=300)[1], "")


if __name__ == "__main__":
    unittest.main()
