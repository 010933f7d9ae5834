#!/usr/bin/python3
"""Runs every client against hostile servers. Each client must end in time, within its memory, with a line
that says why.

    hostile_test.py BIN_DIR MODELS_DIR SOURCE_DIR

With LODE_SANITIZED in the environment the test measures no memory and opens no window.
"""
import contextlib
import os
import re
import shutil
import subprocess
import tempfile
import threading
import time
import unittest

from daemon import BIN, STORE, Daemon
from hostile_server import BEHAVIOURS, HostileServer
from processes import display, start

SANITIZED = "LODE_SANITIZED" in os.environ
BUDGET, BESIDE = 64 << 20, 64 << 20
WINDOW_BUDGET = 256 << 20  # includes the memory of the driver that draws in software
TIMEOUT_S, SLACK_S = 1.5, 12  # the slack is for a busy machine
WITH_A_WINDOW = {"floods Ping and reads nothing", "floods GoAway", "sends a byte at a time", "lies about digests", "stops in a frame"}
HARMLESS = {"sends a byte at a time", "lies about counts"}  # a client may get all that it wants
# Floods of frames that the protocol allows. A client may succeed, if it needs only the root, which precedes
# the flood.
LEGAL_FLOODS = {"floods Ping and reads nothing", "floods Ping and reads", "floods GoAway", "floods frames to skip"}
GOOD_ENDS = {"list", "loadtest"}  # a list needs little, and a load test reports what it measured


def clients(url, folder, with_window):
    """Returns the commands by name, each with its memory budget."""
    lodestream, server = os.path.join(BIN, "lodestream"), url.rsplit("/", 1)[0]
    common = ["--timeout", TIMEOUT_S, "--memory-budget", BUDGET, "--cache", "off"]
    commands = {
        "list": ([lodestream, "list", server, "--timeout", TIMEOUT_S], BUDGET),
        "fetch": ([lodestream, "fetch", url, *common, "--pixels", 0.5], BUDGET),
        "fetch with a cache": ([lodestream, "fetch", url, *common[:-1], os.path.join(folder, "cache"), "--pixels", 0.5], BUDGET),
        "replay": ([lodestream, "replay", url, *common, "--pixels", 0.5], BUDGET),
        "loadtest": ([lodestream, "loadtest", "--full", "--clients", 4, "--ramp", 0, "--seconds", TIMEOUT_S, url, *common], BUDGET),
        "embedded": ([os.path.join(BIN, "embedded_client"), url, TIMEOUT_S, BUDGET], BUDGET),
    }
    if with_window:
        options = [*common, "--screenshot", os.path.join(folder, "a.png"), "--size", "320x240", "--pixels", 0.5]
        options[options.index("--memory-budget") + 1] = WINDOW_BUDGET
        commands["view"] = ([lodestream, "view", url, *options], WINDOW_BUDGET)
    return commands


class Run:
    """Runs a client and records how it ends: status, seconds, peak resident memory, output."""

    def __init__(self, command, **options):
        self.began = time.monotonic()
        self.process = start(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()

    def watch(self):
        with self.process.stdout as output:
            self.lines = output.read().splitlines()
        _, status, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = os.waitstatus_to_exitcode(status)
        self.seconds, self.peak_bytes = time.monotonic() - self.began, usage.ru_maxrss << 10

    def end(self):
        self.thread.join(TIMEOUT_S + SLACK_S)
        self.in_time = not self.thread.is_alive()
        if not self.in_time:
            self.process.kill()
            self.thread.join()


class HostileServers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.daemon = cls.stack.enter_context(Daemon(STORE, stderr=subprocess.DEVNULL))
        commands = subprocess.run([os.path.join(BIN, "lodestream"), "--help"], capture_output=True, text=True).stdout
        has_window = not SANITIZED and shutil.which("Xvfb") and re.search(r"(?m)^\s+view\b", commands)
        cls.screen = cls.stack.enter_context(display()) if has_window else None

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def suffer(self, name):
        """Runs all clients against one hostile server at the same time."""
        with tempfile.TemporaryDirectory() as folder, HostileServer(self.daemon.address, BEHAVIOURS[name]) as server:
            environment = dict(os.environ, HOME=folder, XDG_CACHE_HOME=folder, LIBGL_ALWAYS_SOFTWARE="1", DISPLAY=self.screen or "")
            commands = clients(f"lode://{server.address}/painted", folder, self.screen and name in WITH_A_WINDOW)
            runs = {client: Run(command, env=environment) for client, (command, _) in commands.items()}
            for run in runs.values():
                run.end()
        for client, run in runs.items():
            with self.subTest(server=name, client=client):
                self.assertTrue(run.in_time, f"it ran for {run.seconds:.1f} s")
                if not SANITIZED:
                    self.assertLess(run.peak_bytes, commands[client][1] + BESIDE)
                self.assertIn(run.process.returncode, (0, 1))
                if run.process.returncode != 0:
                    self.assertRegex("\n".join(run.lines), r"(?m)^(lodestream|embedded_client): .*\w")
                elif client not in GOOD_ENDS and name not in HARMLESS | LEGAL_FLOODS:
                    self.fail(f"it came to a good end: {run.lines}")
        if "HOSTILE_TABLE" in os.environ:
            for client, run in runs.items():
                line = next((line for line in run.lines if line.startswith(("lodestream:", "embedded_client:"))), "".join(run.lines[-1:]))
                print(f"{name:40} {client:20} {run.process.returncode} {run.seconds:5.1f} s {run.peak_bytes >> 20:5} MiB  {line[:200]}",
                      flush=True)


def add(name):
    def test(self):
        self.suffer(name)
    setattr(HostileServers, "test_a_server_that_" + name.replace(" ", "_").replace("'", ""), test)


for behaviour in BEHAVIOURS:
    add(behaviour)

if __name__ == "__main__":
    unittest.main()
