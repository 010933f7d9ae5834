#!/usr/bin/python3
"""Tests that a store whose storage stops does not count as damaged: stopped_storage_test.py BIN_DIR
MODELS_DIR SOURCE_DIR"""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from daemon import BIN, MODELS, STORE, Daemon
from processes import eventually

DEADLINE_S = "1"
REPORTED = "cannot be read"


def preloads():
    """Returns the libraries to preload. A sanitizer's library must come first."""
    shim = os.path.join(BIN, "libstopped_storage.so")
    linked = subprocess.run(["ldd", os.path.join(BIN, "lodestreamd")], capture_output=True, text=True).stdout
    sanitizers = [line.split()[2] for line in linked.splitlines() if "libasan" in line or "libtsan" in line]
    return ":".join([*sanitizers, shim])


class StoppedStorage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.models, self.mode, self.log = (os.path.join(folder.name, name) for name in ("models", "mode", "log"))
        os.mkdir(self.models)
        shutil.copy(STORE, os.path.join(self.models, "mounted.lode"))
        shutil.copy(os.path.join(MODELS, "gyroid.lode"), os.path.join(self.models, "local.lode"))

    def storage(self, mode):
        new = pathlib.Path(self.mode + ".new")
        new.write_text(mode)
        new.rename(self.mode)

    def environment(self):
        return dict(os.environ, LD_PRELOAD=preloads(), STOPPED_STORAGE="mounted.lode", STOPPED_STORAGE_MODE=self.mode)

    @contextlib.contextmanager
    def daemon(self, *arguments):
        with open(self.log, "w") as log, Daemon(self.models, "--log-json", *arguments, stderr=log, env=self.environment()) as daemon:
            yield daemon

    def said(self):
        """The log's lines as (kind, message)."""
        lines = [json.loads(line) for line in pathlib.Path(self.log).read_text().splitlines()]
        return [(line["kind"], line["message"]) for line in lines]

    def fetch(self, daemon, model, *options):
        return subprocess.run([os.path.join(BIN, "lodestream"), "fetch", f"lode://{daemon.address}/{model}", "--cache", "off",
                               "--json", "--timeout", "60", "--pixels", "4", *options], capture_output=True, text=True, timeout=120)

    def expect_honest(self, daemon, seconds):
        begin = time.monotonic()
        ended = self.fetch(daemon, "mounted")
        self.assertEqual(ended.returncode, 1, ended.stdout)
        self.assertIn(REPORTED, ended.stderr)
        self.assertNotIn("damage", ended.stderr)
        self.assertLess(time.monotonic() - begin, seconds)

    def expect_named_and_regained(self, daemon):
        self.storage("")
        eventually(lambda: self.fetch(daemon, "mounted").returncode == 0)
        kinds = [kind for kind, _ in self.said()]
        self.assertIn("unreadable", kinds)
        self.assertNotIn("damage", kinds)
        self.assertTrue(any("can be read again" in message for _, message in self.said()), self.said())
        self.assertGreater(daemon.metric('lodestream_model_unreadable_blobs_total{model="mounted"}'), 0)
        self.assertEqual(daemon.metric('lodestream_model_damaged_blobs_total{model="mounted"}'), 0)

    def test_with_slow_reads_serves_whole_models(self):
        with self.daemon("--idle-deadline", "20") as daemon:
            read = [daemon.read_whole("mounted") for _ in range(5)]
        self.assertEqual(read, read[:1] * 5)

    def test_failure_is_logged_and_the_store_recovers(self):
        with self.daemon() as daemon:
            self.storage("eio")
            self.expect_honest(daemon, 20)
            self.assertEqual(self.fetch(daemon, "local").returncode, 0)
            self.expect_named_and_regained(daemon)

    def test_hang_ends_requests_at_the_deadline_and_delays_no_other_store(self):
        with self.daemon("--read-deadline", DEADLINE_S, "--threads", "1") as daemon:
            self.storage("hang")
            fetching = subprocess.Popen([os.path.join(BIN, "lodestream"), "fetch", f"lode://{daemon.address}/mounted", "--cache", "off",
                                         "--timeout", "60"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            begin = time.monotonic()
            self.assertEqual(self.fetch(daemon, "local").returncode, 0)
            self.assertLess(time.monotonic() - begin, 10)
            with fetching:
                self.assertIn(REPORTED, fetching.communicate(timeout=60)[1])
            self.expect_honest(daemon, 20)
            self.expect_named_and_regained(daemon)

    def test_failure_at_the_start_skips_the_store_until_a_reload(self):
        self.storage("eio")
        with self.daemon() as daemon:
            self.assertEqual(daemon.models, ["local"])
            self.assertEqual([store["model"] for store in daemon.skipped], ["mounted"])
            self.assertEqual(daemon.skipped[0]["why"], "mounted.lode: cannot be read at byte 0: Input/output error")
            self.assertEqual(daemon.metric("lodestream_models_skipped"), 1)
            kinds = [kind for kind, _ in self.said()]
            self.assertIn("unreadable", kinds)
            self.assertNotIn("damage", kinds)
            self.storage("")
            daemon.process.send_signal(signal.SIGHUP)
            eventually(lambda: daemon.metric("lodestream_models") == 2)
            self.assertEqual(daemon.metric("lodestream_models_skipped"), 0)
            self.assertEqual(self.fetch(daemon, "mounted").returncode, 0)

    def test_failure_is_not_reported_as_damage_by_commands(self):
        self.storage("eio")
        for command in ("info", "verify", "export", "serve"):
            store = os.path.join(self.models, "mounted.lode")
            more = ["--error", "1", "-o", os.path.join(self.models, "out.ply")] if command == "export" else []
            ended = subprocess.run([os.path.join(BIN, "lodestreamd"), command, store, *more], capture_output=True, text=True,
                                   timeout=120, env=self.environment())
            self.assertEqual(ended.returncode, 1, command)
            self.assertIn("mounted.lode: cannot be read at byte 0: Input/output error\n", ended.stderr)

    def test_hang_does_not_keep_the_server_from_stopping(self):
        with self.daemon("--read-deadline", DEADLINE_S) as daemon:
            self.storage("hang")
            self.expect_honest(daemon, 20)
            begin = time.monotonic()
        self.assertLess(time.monotonic() - begin, 20)
        self.storage("")


class BadStores(unittest.TestCase):
    def test_are_skipped_in_a_folder_unless_strict(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(STORE, folder)
            pathlib.Path(folder, "cut.lode").write_bytes(pathlib.Path(STORE).read_bytes()[:5000])
            pathlib.Path(folder, "junk.lode").write_text("junk")
            with open(os.path.join(folder, "log"), "w") as log, Daemon(folder, stderr=log) as daemon:
                self.assertEqual(daemon.models, ["painted"])
                self.assertEqual([store["model"] for store in daemon.skipped], ["cut", "junk"])
                self.assertIn("truncated: 5000 of", daemon.skipped[0]["why"])
                self.assertGreater(daemon.read_whole()["payloads"], 20)
            said = pathlib.Path(folder, "log").read_text()
            for name in ("cut", "junk"):
                self.assertRegex(said, f"damage: the store of model '{name}' cannot be opened; the model is not served: {name}.lode: ")
            for stores in ([folder, "--strict"], [os.path.join(folder, "cut.lode")], [STORE, os.path.join(folder, "cut.lode")]):
                refused = subprocess.run([os.path.join(BIN, "lodestreamd"), "serve", *stores, "--listen", "127.0.0.1:0"],
                                         capture_output=True, text=True, timeout=120)
                self.assertEqual(refused.returncode, 1, stores)
                self.assertIn("cut.lode: truncated: 5000 of", refused.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
