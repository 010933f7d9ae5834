#!/usr/bin/python3
"""Tests of the memory of lodestreamd during attacks: the memory that it counts, and its resident memory.

    memory_test.py BIN_DIR MODELS_DIR SOURCE_DIR

With LODE_SANITIZED in the environment, tests only the counted memory, because the sanitizer's own memory is resident too.
"""
import contextlib
import functools
import http.client
import os
import resource
import struct
import subprocess
import tempfile
import threading
import time
import unittest

import lodestream_generated as wire
from daemon import STORE, Daemon
from processes import eventually
from read_model import HEADER, Connection

BUDGET, THREADS = 32_000_000, 2
POOLS = THREADS * 64 * (60 << 10)  # buffers that threads keep, in addition to the budget
LEFT = BUDGET // 8 # memory that may stay resident after an attack, in addition to the buffers
SANITIZED = "LODE_SANITIZED" in os.environ
REQUESTS, MAX_BODY, MAX_CHANGES, MAX_OPEN = 7, 262144, 4096, 64


class Recorded:
    """Records the bytes that a connection would send."""

    def __init__(self):
        self.sent = b""
        self.socket = self

    def sendall(self, frame):
        self.sent += frame


def frame(name, **fields):
    recorded = Recorded()
    Connection.send(recorded, name, 3, **fields)
    return recorded.sent


@functools.lru_cache
def requests(count):
    """Returns frames that request `count` blobs of the first opened model."""
    changes = [wire.RequestChangeT() for _ in range(count)]
    for number, change in enumerate(changes, 1):
        change.request, change.blob, change.priorityPx = number, 1 + number % 90, 1.0
    return b"".join(frame("Requests", handle=1, changes=changes[at:at + MAX_CHANGES]) for at in range(0, count, MAX_CHANGES))


def announce_a_frame_and_stop_before_its_end():
    return HEADER.pack(MAX_BODY, REQUESTS, 0, 0, 1) + bytes(MAX_BODY - 1)


def request_much_with_the_window_shut():
    return requests(4 * MAX_CHANGES)


def request_politely_and_never_read():
    return frame("Credit", grantedBytes=1 << 40) + requests(400)


def ping_and_never_read():
    return frame("Ping") * 40_000


def open_as_often_as_allowed():
    return frame("Open", model="painted") * (MAX_OPEN - 1)


ATTACKS = (announce_a_frame_and_stop_before_its_end, request_much_with_the_window_shut, request_politely_and_never_read,
           ping_and_never_read, open_as_often_as_allowed)


class Peaks:
    """Records two peaks during the `with`: the memory that a server counts, and its resident memory above the start."""

    def __init__(self, daemon):
        self.daemon, self.rest, self.counted, self.grown = daemon, self.resident(daemon), 0, 0
        self.over, self.thread = threading.Event(), threading.Thread(target=self.run)

    @staticmethod
    def resident(daemon):
        with open(f"/proc/{daemon.process.pid}/statm") as pages:
            return int(pages.read().split()[1]) * resource.getpagesize()

    def run(self):
        while not self.over.wait(0.02):
            self.counted = max(self.counted, self.daemon.metric("lodestream_memory_bytes"))
            self.grown = max(self.grown, self.resident(self.daemon) - self.rest)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


def attack(daemon, clients, attacks, count):
    """Opens `count` connections that attack by turns. The server may refuse some, and may close some before they have sent
    everything."""
    said = [one() for one in attacks]
    for number in range(count):
        with contextlib.suppress(SystemExit, OSError, struct.error):
            connection, *_ = daemon.open()
            clients.enter_context(contextlib.closing(connection))
            connection.socket.settimeout(0.1)
            connection.socket.sendall(said[number % len(attacks)])


class Budget(unittest.TestCase):
    def expect_kept(self, attacks):
        with Daemon(STORE, "--memory-budget", str(BUDGET), "--threads", str(THREADS), stderr=subprocess.DEVNULL) as daemon:
            daemon.read_whole()
            with contextlib.ExitStack() as clients, Peaks(daemon) as peaks:
                for _ in range(5):
                    attack(daemon, clients, attacks, 100)
                    self.assertGreater(daemon.read_whole()["payloads"], 20)
            self.assertGreater(peaks.grown, BUDGET / 8, "it was no attack")
            self.assertLessEqual(peaks.counted, BUDGET)
            eventually(lambda: daemon.metric("lodestream_memory_bytes") == 0)
            if not SANITIZED:
                self.assertLessEqual(peaks.grown, BUDGET + POOLS)
                eventually(lambda: Peaks.resident(daemon) - peaks.rest <= LEFT + POOLS)
            print(f"{'all' if len(attacks) > 1 else attacks[0].__name__}: counted {peaks.counted / BUDGET:.2f} of the budget, "
                  f"resident {peaks.grown / BUDGET:.2f}, afterwards {(Peaks.resident(daemon) - peaks.rest) / BUDGET:.2f}")

    def test_holds_under_each_attack_and_polite_clients_are_served(self):
        for one in ATTACKS:
            with self.subTest(one.__name__):
                self.expect_kept([one])

    def test_holds_under_all_attacks_at_once(self):
        self.expect_kept(ATTACKS)


@unittest.skipIf(SANITIZED, "a sanitizer takes more address space than there is")
class System(unittest.TestCase):
    def test_without_memory_costs_connections_and_not_the_server(self):
        with tempfile.TemporaryFile("w+") as log, Daemon(
                STORE, "--memory-budget", "4GB", "--threads", "1", stderr=log, env=dict(os.environ, MALLOC_ARENA_MAX="1")) as daemon:
            daemon.read_whole()
            with open(f"/proc/{daemon.process.pid}/statm") as pages:
                now = int(pages.read().split()[0]) * resource.getpagesize()
            most = resource.prlimit(daemon.process.pid, resource.RLIMIT_AS, (now + (8 << 20), resource.RLIM_INFINITY))[1]
            with contextlib.ExitStack() as clients:
                attack(daemon, clients, ATTACKS, 300)
            self.assertIsNone(daemon.process.poll(), "it has ended")

            def all_are_gone():
                with contextlib.suppress(OSError, http.client.HTTPException):  # the request for metrics is a connection too
                    return daemon.metric("lodestream_connections") == 0

            eventually(all_are_gone)
            self.assertGreater(daemon.read_whole()["payloads"], 20)
            resource.prlimit(daemon.process.pid, resource.RLIMIT_AS, (most, most))

            def it_was_short():
                log.seek(0)
                said = log.read()
                return "the system has no memory left" in said or "reason=memory" in said

            eventually(it_was_short)


if __name__ == "__main__":
    unittest.main()
