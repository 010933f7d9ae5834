#!/usr/bin/python3
"""Tests that each limit and deadline of lodestreamd serve follows its option instead of its default.

    limits_test.py BIN_DIR MODELS_DIR SOURCE_DIR
"""
import contextlib
import socket
import time
import unittest

from daemon import STORE, Daemon, requests
from processes import eventually
from read_model import HEADER, LIMIT, Connection


class Limits(unittest.TestCase):
    PING = HEADER.pack(12, 14, 0, 0, 1) + bytes.fromhex("080000000400040004000000")  # a FlatBuffers table without fields

    def test_open_models_are_limited(self):
        with Daemon(STORE, "--max-open-models", "1") as daemon, contextlib.closing(daemon.open()[0]) as connection:
            connection.send("Open", 3, model="painted")
            self.assertIn(f"code {LIMIT}", self.last_word(connection))

    def held_by_a_client_that_pings_and_never_reads(self, *arguments):
        with Daemon(STORE, *arguments) as daemon, contextlib.closing(daemon.open()[0]) as connection:
            # Take the least of several values, because bytes that were just sent may still be counted.
            before = min(daemon.metric("lodestream_memory_bytes") for _ in range(10))
            connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.socket.settimeout(1)
            with self.assertRaises(TimeoutError):  # the server no longer reads
                for _ in range(10000):
                    connection.socket.sendall(self.PING * 1000)
            return daemon.metric("lodestream_memory_bytes") - before

    def test_queued_answers_are_limited(self):
        held = self.held_by_a_client_that_pings_and_never_reads
        for limit, kept in ((4096, held("--max-queued-bytes", "4KiB")), (65536, held())):
            self.assertIn(kept // limit, (1, 2)) # one full queue, and perhaps a second one that is being sent

    def test_bytes_per_second_are_limited(self):
        with Daemon(STORE, "--max-rate", "400KB", "--max-rate-per-connection", "300KB") as daemon:
            start = time.monotonic()
            read = daemon.read_whole()["bytes"]
            self.assertAlmostEqual(read / (time.monotonic() - start), 300e3, delta=60e3)

    def test_open_requests_are_limited(self):
        with Daemon(STORE, "--max-requests", "10") as daemon:
            connection, _, most = daemon.open()
            with contextlib.closing(connection):
                self.assertEqual(most, 10)
                connection.send("Requests", 3, handle=1, changes=requests(11))
                self.assertIn(f"code {LIMIT}", self.last_word(connection))

    def test_connections_per_address_are_limited(self):
        with Daemon(STORE, "--max-connections-per-address", "1") as daemon:
            with contextlib.closing(daemon.open()[0]), contextlib.closing(Connection(daemon.address)) as second:
                self.assertIn(f"code {LIMIT}", self.last_word(second))

    def test_connections_are_counted_per_client_behind_a_balancer(self):
        with Daemon(STORE, "--proxy-protocol", "--max-connections-per-address", "1") as daemon:
            with self.from_behind(daemon, "192.0.2.1") as first, self.from_behind(daemon, "192.0.2.2") as other:
                for connection in (first, other):
                    self.assertGreater(connection.open("painted")[1], 0)
                with self.from_behind(daemon, "192.0.2.1") as second:
                    self.assertIn(f"code {LIMIT}", self.last_word(second))

    def expect_ended(self, reason, option, client):
        """Expects that the server ends the connection within seconds. The default deadlines are ten seconds and more."""
        with Daemon(STORE, option, "0.3") as daemon, contextlib.closing(client(daemon)):
            start = time.monotonic()
            eventually(lambda: daemon.metric(f'lodestream_connections_ended_total{{reason="{reason}"}}') == 1)
            self.assertLess(time.monotonic() - start, 8)

    def test_the_handshake_deadline_is_enforced(self):
        self.expect_ended("handshake", "--handshake-deadline", lambda daemon: Connection(daemon.address))

    def test_the_idle_deadline_is_enforced(self):
        self.expect_ended("idle", "--idle-deadline", lambda daemon: daemon.open()[0])

    def test_the_write_deadline_is_enforced(self):
        self.expect_ended("stalled", "--write-deadline", self.that_takes_nothing)

    def that_takes_nothing(self, daemon):
        connection = daemon.open()[0]
        connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.send("Credit", grantedBytes=1 << 40)
        connection.send("Requests", 3, handle=1, changes=requests(4000))
        return connection

    @contextlib.contextmanager
    def from_behind(self, daemon, address):
        with contextlib.closing(Connection(daemon.address)) as connection:
            connection.socket.sendall(f"PROXY TCP4 {address} 192.0.2.9 4000 7400\r\n".encode())
            yield connection

    def last_word(self, connection):
        """Returns the Error that ends a connection."""
        with self.assertRaises(SystemExit) as said:
            while True:
                connection.receive()
        return str(said.exception)


if __name__ == "__main__":
    unittest.main()
