#!/usr/bin/python3
"""Tests the native protocol over WebSockets: websocket_test.py BIN_DIR MODELS_DIR SOURCE_DIR"""
import contextlib
import filecmp
import json
import os
import pathlib
import shutil
import ssl
import subprocess
import tempfile
import time
import unittest

from daemon import BIN, STORE, Daemon
from processes import eventually, self_signed
from read_model import HEADER, Connection, Reader
from websocket_client import CLOSE, PING, PONG, TEXT, Relay, WebSocket, frame

import lodestream_generated as wire


class Web(Daemon):
    def __init__(self, *arguments):
        super().__init__(STORE, "--http", "127.0.0.1:0", *arguments, stderr=subprocess.DEVNULL)


class WebConnection(Connection):
    """The independent client over a WebSocket."""

    def __init__(self, websocket):
        self.socket, self.input, self.credited = websocket, websocket, 0

    def close(self):
        self.socket.close()


def error_of(websocket):
    """Reads frames of the protocol until an Error; returns its message."""
    while True:
        size, kind, *_ = HEADER.unpack(websocket.read(HEADER.size))
        body = websocket.read(size)
        if kind == 11:
            return wire.Error.GetRootAs(body).Message().decode()


def fetch(address, output):
    """Runs `lodestream fetch`. Returns the values that do not depend on time."""
    done = subprocess.run([os.path.join(BIN, "lodestream"), "fetch", f"lode://{address}/painted", "--cache", "off", "--json", "--pixels", "0.5",
                           "-o", output], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    values = json.loads(done.stdout)
    return {name: values[name] for name in ("converged", "triangles", "nodes", "max_error_px", "final_cut_bytes")}


class WebSockets(unittest.TestCase):
    def open(self, server, **options):
        websocket = WebSocket(server.http, **options)
        self.addCleanup(websocket.close)
        return websocket

    def test_carry_whole_models(self):
        with Web() as server:
            direct = server.read_whole()
            for seed in (None, 1, 2):
                with contextlib.closing(WebConnection(self.open(server, seed=seed))) as connection:
                    self.assertEqual(Reader(connection, *connection.open("painted")).run(), direct)
                    if seed:
                        self.assertIn((PONG, b"p"), connection.socket.answers)

    def test_carry_the_same_cut_to_the_native_client(self):
        with Web() as server, tempfile.TemporaryDirectory() as folder:
            files = [os.path.join(folder, name) for name in ("direct.ply", "relayed.ply")]
            wanted = fetch(server.address, files[0])
            with Relay(server.http) as relay:
                self.assertEqual(fetch(relay.address, files[1]), wanted)
            self.assertTrue(filecmp.cmp(*files, shallow=False))

    @unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
    def test_are_encrypted(self):
        with tempfile.TemporaryDirectory() as folder:
            certificate = self_signed(pathlib.Path(folder))
            with Web("--tls-cert", f"{certificate}/cert.pem", "--tls-key", f"{certificate}/key.pem") as server:
                context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
                context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
                with contextlib.closing(WebConnection(self.open(server, tls=context))) as connection:
                    self.assertGreater(Reader(connection, *connection.open("painted")).run()["payloads"], 20)

    def test_are_for_pages_of_the_server(self):
        with Web() as server:
            self.assertEqual(self.open(server, Origin=f"http://{server.http}").status, 101)
            self.assertEqual(self.open(server, Origin="http://elsewhere").status, 403)
            self.assertEqual(self.open(server, Origin="null").status, 403)
            self.assertEqual(self.open(server, Host="rebound.example", Origin="http://rebound.example").status, 421)
        with Web("--public") as server:
            self.assertEqual(self.open(server, Origin="http://elsewhere").status, 101)

    def test_need_a_valid_request(self):
        with Web() as server:
            for status, fields in ((426, dict(Upgrade=None)), (426, dict(Sec_WebSocket_Version="8")), (400, dict(Sec_WebSocket_Key="x")),
                                   (400, dict(Sec_WebSocket_Key=None)), (426, dict(Connection="keep-alive"))):
                websocket = self.open(server, **fields)
                self.assertEqual(websocket.status, status, fields)
            self.assertEqual(self.open(server, Upgrade=None).head["sec-websocket-version"], "13")

    def test_need_tokens_as_the_native_port(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = os.path.join(folder, "tokens")
            with open(tokens, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
                file.write("right never *\n")
            with Web("--token-file", tokens) as server:
                with contextlib.closing(WebConnection(self.open(server))) as connection:
                    connection.open("painted", "right")
                with contextlib.closing(WebConnection(self.open(server))) as connection:
                    connection.send("Hello", 1, minVersion=4, maxVersion=4, token="wrong", program="test")
                    self.assertIn("token", error_of(connection.socket))

    def test_answer_ping_and_close(self):
        with Web() as server:
            websocket = self.open(server)
            websocket.socket.sendall(frame(PING, b"hello") + frame(CLOSE, b"\x03\xe9bye"))
            self.assertEqual(websocket.receive(), (PONG, b"hello"))
            self.assertEqual(websocket.receive(), (CLOSE, b"\x03\xe9"))
            self.assertIsNone(websocket.receive())

    def test_refuse_other_frames_with_a_reason(self):
        with Web() as server:
            for sent, why in ((frame(TEXT, b"hello"), "text"), (b"\x82\x01x", "masked"), (frame(3, b""), "opcode"),
                              (frame(2, b"\xff" * 12), "")):
                websocket = self.open(server)
                websocket.socket.sendall(sent)
                self.assertIn(why, error_of(websocket))
                self.assertEqual(websocket.recv(), b"")
                self.assertEqual(websocket.closed_with, b"\x03\xe8")

    def test_have_the_deadlines_and_the_memory_of_the_native_port(self):
        with Web("--handshake-deadline", "0.5", "--write-deadline", "0.5") as server:
            silent = self.open(server)
            self.assertIsNone(silent.receive(), "no Hello came in time")
            deaf = WebConnection(self.open(server))
            opened, _ = deaf.open("painted")
            deaf.send("Credit", grantedBytes=1 << 40)
            changes = [wire.RequestChangeT() for _ in range(4000)]
            for number, change in enumerate(changes, 1):
                change.request, change.blob = number, 1 + number % 90
            deaf.send("Requests", 3, handle=opened.Handle(), changes=changes)
            eventually(lambda: server.metric('lodestream_connections_ended_total{reason="stalled"}') == 1)
            deaf.close()
            eventually(lambda: server.metric("lodestream_memory_bytes") == 0)
            self.assertEqual(server.metric("lodestream_connections_accepted_total"), 2)
            self.assertEqual(server.metric('lodestream_http_responses_total{status="101"}'), 2)

    def test_withstand_hostile_clients(self):
        attacks = (
            b"\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff" + bytes(4) + bytes(100_000),  # a frame of 2^63 bytes
            b"".join(frame(PING, b"p" * 125) for _ in range(20_000)),  # pings, whose answers are never read
            frame(2, b"", final=False) + b"".join(frame(0, b"", final=False) for _ in range(20_000)),  # a message of nothing
            frame(2, HEADER.pack(262144, 7, 0, 0, 1)) + frame(2, bytes(100)),  # a large frame before Hello
            b"\x82", b"\x82\xff", bytes(100), os.urandom(10_000))
        with Web("--handshake-deadline", "1", "--write-deadline", "1", "--memory-budget", "16MB") as server:
            clients = []
            for number in range(160):
                websocket = self.open(server)
                clients.append(websocket)
                websocket.socket.settimeout(0.2)
                with contextlib.suppress(OSError):
                    websocket.socket.sendall(attacks[number % len(attacks)])
            with contextlib.closing(WebConnection(self.open(server))) as connection:
                self.assertGreater(Reader(connection, *connection.open("painted")).run()["payloads"], 20)
            eventually(lambda: server.metric("lodestream_connections") == 0, 30)
            eventually(lambda: server.metric("lodestream_memory_bytes") == 0)

    def test_end_with_the_server(self):
        with Web() as server:
            websocket = self.open(server)
            connection = WebConnection(websocket)
            connection.open("painted")
            server.process.terminate()
            began = time.monotonic()
            kinds = []
            while head := websocket.read(HEADER.size):
                size, kind, _, _, call = HEADER.unpack(head)
                body = websocket.read(size)
                kinds.append(kind)
                if kind == 14:
                    connection.send("Pong", call, payload=wire.Ping.GetRootAs(body).Payload())
            self.assertIn(12, kinds, "GoAway")
            self.assertEqual(websocket.closed_with, b"\x03\xe8")
            self.assertLess(time.monotonic() - began, 4)
            self.assertEqual(server.process.wait(timeout=60), 0)


if __name__ == "__main__":
    unittest.main()
