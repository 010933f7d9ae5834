#!/usr/bin/python3
"""Runs hostile HTTP clients against a server. The server must stay within its memory, end these clients in
time, and serve polite clients meanwhile.

    hostile_http_test.py BIN_DIR MODELS_DIR SOURCE_DIR

With LODE_SANITIZED in the environment the test measures no resident memory.
"""
import contextlib
import http.client
import json
import os
import random
import resource
import socket
import subprocess
import threading
import time
import unittest

from daemon import STORE, Daemon
from processes import eventually

SANITIZED = "LODE_SANITIZED" in os.environ
BUDGET, CACHE = 16_000_000, 4_000_000
SLACK = 24 << 20  # meshes while tiles are made, buffers of threads, and memory that malloc keeps
CLIENTS = 200
GET = "GET {} HTTP/1.1\r\nHost: localhost\r\n\r\n"


class Web(Daemon):
    """A server with short deadlines and a port for HTTP."""

    def __init__(self, *arguments, patience_s=1):
        super().__init__(STORE, "--http", "127.0.0.1:0", "--http-memory", str(CACHE), "--memory-budget", str(BUDGET), "--threads", "2",
                         "--handshake-deadline", str(patience_s), "--write-deadline", str(patience_s), "--idle-deadline",
                         str(2 * patience_s), *arguments,
                         stderr=subprocess.DEVNULL)
        self.host, port = self.http.rsplit(":", 1)
        self.port = int(port)
        tileset = json.loads(self.get("/painted/tileset.json")[1])
        self.tiles, todo = [], [tileset["root"]]
        while todo:
            tile = todo.pop()
            todo += tile.get("children", [])
            if tile.get("content", {}).get("uri", "").startswith("g/"):
                self.tiles.append("/painted/" + tile["content"]["uri"])

    def get(self, path):
        with contextlib.closing(http.client.HTTPConnection(self.host, self.port, timeout=60)) as client:
            client.request("GET", path)
            response = client.getresponse()
            return response.status, response.read()

    def connect(self):
        client = socket.socket()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.settimeout(60)
        client.connect((self.host, self.port))
        return client

    def resident(self):
        with open(f"/proc/{self.process.pid}/statm") as pages:
            return int(pages.read().split()[1]) * resource.getpagesize()


def read_to_end(client):
    received = b""
    with contextlib.suppress(OSError):
        while part := client.recv(65536):
            received += part
    return received


class HostileClients(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        self.server = self.stack.enter_context(Web())
        for tile in self.server.tiles:
            self.server.get(tile)
        self.rest = self.server.resident()

    def suffer(self, attack, within_s=30):
        """Runs an attack of many clients. The server must end all of them in time; polite clients are served meanwhile."""
        over, connected = threading.Event(), []

        def one(number):
            with contextlib.suppress(OSError), contextlib.closing(self.server.connect()) as client:
                connected.append(number)
                attack(client, number, over)
                client.settimeout(60)
                over.wait()

        began = time.monotonic()
        threads = [threading.Thread(target=one, args=(number,)) for number in range(CLIENTS)]
        for thread in threads:
            thread.start()
        peak, slowest = 0, 0
        while len(connected) < CLIENTS or self.server.metric("lodestream_connections") > 0:
            asked = time.monotonic()
            status, body = self.server.get(self.server.tiles[0])
            slowest = max(slowest, time.monotonic() - asked)
            self.assertEqual((status, body[:4]), (200, b"glTF"))
            peak = max(peak, self.server.metric("lodestream_memory_bytes"))
            self.assertLess(time.monotonic() - began, within_s, "the server has not ended all clients")
        over.set()
        for thread in threads:
            thread.join()
        self.assertLessEqual(peak, BUDGET)
        self.assertLessEqual(self.server.metric("lodestream_http_cache_bytes"), CACHE)
        if not SANITIZED:
            self.assertLess(self.server.resident() - self.rest, BUDGET + CACHE + SLACK)
        eventually(lambda: self.server.metric("lodestream_memory_bytes") == 0)
        print(f"{self.id().rsplit('.', 1)[1]}: counted {peak / BUDGET:.2f} of the budget, slowest polite client {slowest:.2f} s, "
              f"{time.monotonic() - began:.1f} s in all", flush=True)

    def test_that_send_a_byte_at_a_time(self):
        def attack(client, number, over):
            for byte in GET.format("/" + "x" * 4000).encode():
                client.send(bytes([byte]))
                over.wait(0.1)
        self.suffer(attack)

    def test_that_connect_and_say_nothing(self):
        self.suffer(lambda client, number, over: None)

    def test_that_stop_within_a_head(self):
        self.suffer(lambda client, number, over: client.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 7000))

    def test_that_ask_for_much_and_never_read(self):
        def attack(client, number, over):
            flood = "".join(GET.format(tile) for tile in self.server.tiles * 20).encode()
            client.settimeout(3)
            client.sendall(flood)
            client.settimeout(60)
            while not over.wait(0.2):
                client.send(b"\r\n")
        self.suffer(attack)

    def test_that_read_a_byte_at_a_time(self):
        def attack(client, number, over):
            client.sendall("".join(GET.format(tile) for tile in self.server.tiles * 5).encode())
            while client.recv(1) and not over.wait(0.05):
                pass
        self.suffer(attack)

    def test_that_flood_with_pipelined_requests(self):
        def attack(client, number, over):
            client.sendall((GET.format("/nothing") * 2000).encode())
            client.shutdown(socket.SHUT_WR)
        self.suffer(attack)

    def test_that_send_bodies(self):
        def attack(client, number, over):
            method = ("GET", "POST", "PUT", "OPTIONS")[number % 4]
            framing = ("Content-Length: 1000000000", "Transfer-Encoding: chunked")[number // 4 % 2]
            client.sendall(f"{method} / HTTP/1.1\r\nHost: localhost\r\n{framing}\r\n\r\n".encode())
            for _ in range(100):
                client.sendall(b"ffff\r\n" + bytes(0xffff) + b"\r\n")
        self.suffer(attack)

    def test_that_send_noise(self):
        def attack(client, number, over):
            chance = random.Random(number)
            client.sendall(chance.choice((b"", b"GET ", b"\x16\x03\x01\x02\x00\x01", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n")))
            client.sendall(chance.randbytes(chance.randrange(20000)) + b"\r\n\r\n")
        self.suffer(attack)


class Refusals(unittest.TestCase):
    def test_name_their_reason(self):
        with Web() as server:
            for request, status in (
                    ("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + "x" * 9000, 431), ("GET / HTTP/1.1\r\n\r\n", 400),
                    ("GET / HTTP/1.1\r\nHost: localhost\r\nHost: b\r\n\r\n", 400), ("GET /%zz HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
                    ("GET /../../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", 404), ("GET /%2e%2e%2fetc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", 404),
                    ("GET / HTTP/3.0\r\nHost: localhost\r\n\r\n", 505), ("DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n", 405),
                    ("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\n\r\nx", 413), ("GET * HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
                    ("CONNECT a:1 HTTP/1.1\r\nHost: localhost\r\n\r\n", 405), ("\r\n\r\n\r\n\r\n", 400),
                    ("GET / HTTP/1.1\r\nHost: rebound.example\r\n\r\n", 421)):
                with self.subTest(request[:40]), contextlib.closing(server.connect()) as client:
                    client.sendall(request.encode())
                    client.shutdown(socket.SHUT_WR)
                    received = read_to_end(client)
                    self.assertEqual(received.split(b" ", 2)[1], str(status).encode())
                    self.assertTrue(received.endswith(b"\n"), "the body names the reason")

    def test_come_with_a_status_if_the_server_is_full(self):
        with Web("--max-connections", "4") as server, contextlib.ExitStack() as clients:
            def is_full():
                client = clients.enter_context(contextlib.closing(server.connect()))
                client.settimeout(0.3)
                with contextlib.suppress(OSError):
                    return client.recv(100).startswith(b"HTTP/1.1 503 ")
            eventually(is_full)
            clients.close()
            eventually(lambda: server.get("/models.json")[0] == 200)

    def test_do_not_depend_on_idle_connections(self):
        with Web(patience_s=60) as server, contextlib.ExitStack() as clients:
            rest = server.resident()
            for _ in range(1000):
                client = clients.enter_context(contextlib.closing(server.connect()))
                client.sendall(GET.format("/models.json").encode())
                self.assertTrue(client.recv(4096).startswith(b"HTTP/1.1 200 "))
            if not SANITIZED:
                self.assertLess(server.resident() - rest, 1000 * 20_000)
            began = time.monotonic()
            for _ in range(50):
                self.assertEqual(server.get(server.tiles[0])[0], 200)
            self.assertLess(time.monotonic() - began, 10)


if __name__ == "__main__":
    unittest.main()
