#!/usr/bin/env python3
"""Tests of `lodestreamd serve` on object storage: object_storage_test.py BIN MODELS

BIN has the programs, MODELS the stores of make_models.sh. An S3 server runs on loopback, and rclone mounts its bucket with the
options of docs/operations.md. The tests need rclone, fusermount3, /dev/fuse, node, and in NODE_PATH the package that this command
installs:
  npm install s3rver@3.7.1
Without these they are skipped.
"""
import contextlib
import ctypes
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from http_served import BIN, MODELS, Served

SERVER = pathlib.Path(__file__).resolve().parent / "object_storage" / "server.cjs"
STORE = MODELS / "asteroid2m.lode"
MOUNT_OPTIONS = ["--read-only", "--vfs-cache-mode", "full", "--vfs-cache-max-size", "1G", "--vfs-read-chunk-size", "1M",
                 "--vfs-read-chunk-size-limit", "4M", "--buffer-size", "0", "--use-server-modtime", "--contimeout", "10s",
                 "--timeout", "30s"]
COARSE, FINE = 16, 1  # errors in pixels
UNREADABLE = "cannot be read"
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1


def start(command, **options):
    """Starts a process, which the system kills when this process ends."""
    return subprocess.Popen([str(part) for part in command], preexec_fn=lambda: LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL), **options)


def eventually(what, seconds=120):
    """Calls what() until its result is true, and returns the result."""
    end = time.monotonic() + seconds
    while not (found := what()):
        if time.monotonic() > end:
            raise AssertionError("it did not come to that")
        time.sleep(0.05)
    return found


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Bucket:
    """An S3 server on loopback, with its bucket "stores"."""

    def __init__(self, folder):
        self.folder, self.port = folder / "s3", free_port()
        self.log, self.complaints = folder / "requests", folder / "complaints"
        self.log.touch()
        self.start()

    def start(self):
        starts = self.log.read_text().count('"listen"')
        with open(self.log, "a") as log, open(self.complaints, "w") as complaints:
            self.process = start(["node", SERVER, self.folder, self.port, 0], stdout=log, stderr=complaints)
        eventually(lambda: self.log.read_text().count('"listen"') > starts or self.process.poll() is not None)
        if self.process.poll() is not None:
            said = self.complaints.read_text().strip()
            raise unittest.SkipTest(said) if self.process.returncode == 77 else AssertionError(said)

    def stop(self):
        self.process.kill()
        self.process.wait(timeout=60)

    def requests(self):
        """The requests and the ends of responses so far."""
        lines = [json.loads(line) for line in self.log.read_text().splitlines(True) if line.endswith("\n")]
        return [line for line in lines if "method" in line], sum("sent_bytes" in line for line in lines)

    def range_requests(self):
        """Waits until all responses have ended, because rclone reads ahead. Returns the ranges that were read so far."""
        def settled():
            begun, ended = self.requests()
            return begun if len(begun) == ended else None
        return [request["range"] for request in eventually(settled) if request["range"]]


class Mount:
    """The bucket as a read-only folder."""

    def __init__(self, bucket, folder):
        self.path, self.log = folder / "mounted", folder / "rclone.log"
        self.path.mkdir()
        (folder / "rclone.conf").touch()
        setting = {"type": "s3", "provider": "Other", "endpoint": f"http://127.0.0.1:{bucket.port}", "access_key_id": "S3RVER",
                   "secret_access_key": "S3RVER", "force_path_style": "true"}
        # rclone 1.60 fails if AWS_CA_BUNDLE is set.
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith("AWS_")}
        self.environment.update({f"RCLONE_CONFIG_S3_{name.upper()}": value for name, value in setting.items()})
        self.environment.update(RCLONE_CONFIG=str(folder / "rclone.conf"), RCLONE_CACHE_DIR=str(folder / "cache"))
        self.options = []

    def copy(self, store, name=None):
        subprocess.run(["rclone", "copyto", str(store), f"s3:stores/{name or store.name}"], env=self.environment, check=True, timeout=120,
                       capture_output=True)

    def __enter__(self):
        with open(self.log, "w") as log:
            self.process = start(["rclone", "mount", "s3:stores", self.path, *MOUNT_OPTIONS, *self.options], env=self.environment,
                                 stdout=log, stderr=log)
        eventually(lambda: os.path.ismount(self.path) or self.process.poll() is not None)
        if self.process.poll() is not None:
            raise unittest.SkipTest(f"rclone cannot mount here: {self.log.read_text().strip()}")
        return self

    def __exit__(self, *_):
        subprocess.run(["fusermount3", "-u", "-z", str(self.path)], check=False, capture_output=True)
        self.process.terminate()
        self.process.wait(timeout=60)


def fetch(server, pixels):
    """Returns the exit status of `lodestream fetch`, its JSON or its message, and the seconds that it took."""
    began = time.monotonic()
    done = subprocess.run([str(BIN / "lodestream"), "fetch", f"lode://{server.native}/{STORE.stem}", "--cache", "off", "--json",
                           "--timeout", "60", "--pixels", str(pixels)], capture_output=True, text=True, timeout=120)
    return done.returncode, json.loads(done.stdout) if done.returncode == 0 else done.stderr, time.monotonic() - began


def lacking():
    for program in ("rclone", "fusermount3", "node"):
        if not shutil.which(program):
            return f"{program} is not installed"
    return None if os.access("/dev/fuse", os.R_OK | os.W_OK) else "/dev/fuse cannot be opened"


@unittest.skipIf(lacking(), lacking())
class ObjectStorage(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.bucket = Bucket(folder)
        stack.callback(self.bucket.stop)
        self.stack, self.mount = stack, Mount(self.bucket, folder)
        self.mount.copy(STORE)
        self.store = self.mount.path / STORE.name

    def serve(self, *arguments):
        self.stack.enter_context(self.mount)
        return self.stack.enter_context(Served(self.store, *arguments))

    def expect_unreadable(self, server, pixels, seconds):
        status, said, took_s = fetch(server, pixels)
        self.assertEqual(status, 1, said)
        self.assertIn(UNREADABLE, said)
        self.assertNotIn("damage", said)
        self.assertLess(took_s, seconds)

    def expect_recovered(self, server, pixels):
        eventually(lambda: fetch(server, pixels)[0] == 0)
        logged = server.logged()
        self.assertIn(f"unreadable: the store of model '{STORE.stem}' {UNREADABLE}", logged)
        self.assertIn("can be read again", logged)
        self.assertNotIn("damage", logged)
        self.assertGreater(server.metric(f'lodestream_model_unreadable_blobs_total{{model="{STORE.stem}"}}'), 0)
        self.assertEqual(server.metric(f'lodestream_model_damaged_blobs_total{{model="{STORE.stem}"}}'), 0)

    def test_shows_what_a_local_disk_shows_and_a_second_view_reads_nothing(self):
        server = self.serve()
        opening = self.bucket.range_requests()
        self.assertLessEqual(len(opening), 4, "header, table, pages, and the end of a chunk")
        status, view, _ = fetch(server, FINE)
        self.assertEqual(status, 0, view)
        first = self.bucket.range_requests()
        self.assertGreater(len(first), len(opening))
        status, again, _ = fetch(server, FINE)
        self.assertEqual(status, 0, again)
        self.assertEqual(self.bucket.range_requests(), first)
        with Served(STORE) as local:
            status, expected, _ = fetch(local, FINE)
        self.assertEqual(status, 0, expected)
        for key in ("nodes", "triangles"):
            self.assertEqual([view[key], again[key]], [expected[key]] * 2, key)

    def test_that_fails_ends_requests_with_errors_and_recovers_without_a_restart(self):
        server = self.serve()
        self.assertEqual(fetch(server, COARSE)[0], 0)
        self.bucket.stop()
        self.expect_unreadable(server, FINE, 60)
        self.bucket.start()
        self.expect_recovered(server, FINE)

    def test_that_hangs_ends_requests_at_the_deadline_and_recovers_without_a_restart(self):
        server = self.serve("--read-deadline", "1")
        self.assertEqual(fetch(server, COARSE)[0], 0)
        self.bucket.process.send_signal(signal.SIGSTOP)
        self.expect_unreadable(server, FINE, 30)
        self.bucket.process.send_signal(signal.SIGCONT)
        self.expect_recovered(server, FINE)

    def test_shows_a_new_build_after_its_link_is_replaced(self):
        links = self.mount.path.parent / "links"
        links.mkdir()
        link, new = links / STORE.name, links / "new"
        link.symlink_to(self.store)
        self.stack.enter_context(self.mount)
        server = self.stack.enter_context(Served(link))

        def build_id():
            return json.loads(server.ask("/models.json")[2])["models"][0]["build_id"]
        before = build_id()
        self.mount.copy(MODELS / "painted.lode", "second.lode")
        self.mount.process.send_signal(signal.SIGHUP)  # rclone forgets its lists
        second = self.mount.path / "second.lode"
        eventually(second.exists)
        new.symlink_to(second)
        new.rename(link)
        self.assertEqual(build_id(), before)
        server.process.send_signal(signal.SIGHUP)
        eventually(lambda: build_id() != before)
        self.assertEqual(fetch(server, FINE)[0], 0)
        self.assertNotIn("damage", server.logged())

    def test_that_fails_is_not_reported_as_damage_by_verify(self):
        self.mount.options = ["--low-level-retries", "1"]  # by default rclone retries for minutes
        self.stack.enter_context(self.mount)
        subprocess.run([str(BIN / "lodestreamd"), "info", str(self.store)], check=True, capture_output=True, timeout=120)
        self.bucket.stop()
        done = subprocess.run([str(BIN / "lodestreamd"), "verify", str(self.store)], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, rf"{STORE.name}: cannot be read at byte \d+: Input/output error\n$")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
