#!/usr/bin/env python3
"""Tests of `lodestreamd serve --http`: http_test.py BIN MODELS

BIN has the programs, MODELS the stores of make_models.sh. The test of TLS needs openssl, the tests of curl need curl; without
them these tests are skipped.
"""
import contextlib
import gzip
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from http_served import BIN, MODELS, Served, ask, export, links_of

IMMUTABLE = "max-age=31536000, immutable"


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.folder = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        cls.stores = cls.folder / "stores"
        cls.stores.mkdir()
        for name in ("painted", "gyroid"):
            shutil.copy(MODELS / f"{name}.lode", cls.stores)
        shutil.copy(MODELS / "painted_in_small_nodes.lode", cls.stores / "a b&ü.lode")
        cls.files = {name: export(MODELS / f"{store}.lode", cls.folder / name)
                     for name, store in (("painted", "painted"), ("gyroid", "gyroid"), ("a b&ü", "painted_in_small_nodes"))}
        cls.server = cls.stack.enter_context(Served(cls.stores))

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def ask(self, path, method="GET", **headers):
        return self.server.ask(path, method, **headers)

    def tile(self):
        return "/gyroid/" + next(name for name in self.files["gyroid"] if name.startswith("g/"))

    def test_are_the_bytes_of_the_export(self):
        for model, path in (("painted", "painted"), ("gyroid", "gyroid"), ("a b&ü", "a%20b%26%C3%BC")):
            with contextlib.closing(self.server.connect()) as connection:
                for name in self.files[model]:
                    status, head, body = ask(connection, f"/{path}/{name}")
                    self.assertEqual(status, 200, name)
                    self.assertEqual(body, (self.folder / model / name).read_bytes(), name)
                    self.assertEqual(head["content-type"], "model/gltf-binary" if name.startswith("g/") else "application/json")
                    self.assertIn(IMMUTABLE if "/" in name else "no-cache", head["cache-control"])
        self.assertGreater(sum(len(names) for names in self.files.values()), 50)

    def test_of_a_tileset_are_reached_by_its_links(self):
        model = json.loads(self.ask("/models.json")[2])["models"][0]
        self.assertEqual(model["name"], "a b&ü")
        tileset = json.loads(self.ask("/" + model["tileset"])[2])
        self.assertEqual(tileset["asset"]["tilesetVersion"], model["build_id"])
        base = "/" + model["tileset"].rsplit("/", 1)[0] + "/"
        self.assertEqual([self.ask(base + link)[0] for link in links_of(tileset)[:5]], [200] * 5)

    def test_are_listed(self):
        status, head, body = self.ask("/models.json")
        self.assertEqual((status, head["cache-control"]), (200, "no-cache"))
        self.assertEqual([model["name"] for model in json.loads(body)["models"]], ["a b&ü", "gyroid", "painted"])

    def test_are_sent_again_only_if_they_changed(self):
        for path in ("/models.json", "/gyroid/tileset.json", self.tile()):
            tag = self.ask(path)[1]["etag"]
            status, head, body = self.ask(path, If_None_Match=f'"x", W/{tag}')
            self.assertEqual((status, head["etag"], body), (304, tag, b""), path)
            self.assertNotIn("content-length", head)
            self.assertEqual(self.ask(path, If_None_Match='"x"')[0], 200, path)

    def test_are_compressed_if_they_are_json(self):
        for path in ("/models.json", "/gyroid/tileset.json", "/"):
            plain = self.ask(path)
            packed = self.ask(path, Accept_Encoding="gzip, br")
            self.assertEqual(packed[1]["content-encoding"], "gzip")
            self.assertEqual(gzip.decompress(packed[2]), plain[2])
            self.assertNotEqual(packed[1]["etag"], plain[1]["etag"])
            self.assertEqual(plain[1]["vary"], "Accept-Encoding")
        self.assertNotIn("content-encoding", self.ask(self.tile(), Accept_Encoding="gzip")[1])

    def test_have_ranges(self):
        path = self.tile()
        whole = self.ask(path)
        self.assertEqual(whole[1]["accept-ranges"], "bytes")
        status, head, body = self.ask(path, Range="bytes=10-19")
        self.assertEqual((status, body, head["content-range"]), (206, whole[2][10:20], f"bytes 10-19/{len(whole[2])}"))
        self.assertEqual(self.ask(path, Range="bytes=-7")[2], whole[2][-7:])
        self.assertEqual(self.ask(path, Range="bytes=10-19", If_Range=whole[1]["etag"])[0], 206)
        self.assertEqual(self.ask(path, Range="bytes=10-19", If_Range='"x"')[::2], whole[::2])
        self.assertEqual(self.ask(path, Range="bytes=1-2,4-5")[::2], whole[::2])
        status, head, body = self.ask(path, Range="bytes=99999999-")
        self.assertEqual((status, head["content-range"], body), (416, f"bytes */{len(whole[2])}", b""))

    def test_have_heads(self):
        for path in (self.tile(), "/gyroid/tileset.json", "/nothing"):
            get, head = self.ask(path), self.ask(path, "HEAD")
            self.assertEqual(head[2], b"")
            self.assertEqual(get[0], head[0])
            self.assertEqual(get[1]["content-length"], head[1]["content-length"])

    def test_can_be_read_by_pages_of_other_hosts(self):
        status, head, _ = self.ask(self.tile(), "OPTIONS", Origin="http://a", Access_Control_Request_Headers="authorization")
        self.assertEqual(status, 204)
        self.assertIn("Authorization", head["access-control-allow-headers"])
        for path in (self.tile(), "/nothing", "/"):
            head = self.ask(path)[1]
            self.assertEqual((head["access-control-allow-origin"], head["timing-allow-origin"]), ("*", "*"))
            self.assertEqual(head["x-content-type-options"], "nosniff")
            self.assertNotIn("'unsafe", head["content-security-policy"])

    def test_that_do_not_exist_are_refused(self):
        for path in ("/nothing", "/gyroid", "/gyroid/", "/other/tileset.json", "/../gyroid.lode", "/gyroid/../painted/tileset.json",
                     "/painted/" + self.tile().split("/", 2)[2], "/%2e%2e/%2e%2e/etc/passwd"):
            self.assertEqual(self.ask(path)[0], 404, path)
        for path in ("/%zz", "/a%00/tileset.json", "/%ff/tileset.json"):
            self.assertEqual(self.ask(path)[0], 400, path)

    def test_are_read_only(self):
        for method in ("POST", "PUT", "DELETE", "PATCH", "BREW"):
            status, head, _ = self.ask(self.tile(), method)
            self.assertEqual((status, head["allow"]), (405, "GET, HEAD, OPTIONS"), method)
        with contextlib.closing(self.server.connect()) as connection:
            connection.request("POST", "/", body=b"x" * 100000)
            self.assertEqual(connection.getresponse().status, 405)
        with contextlib.closing(self.server.connect()) as connection:
            connection.request("GET", "/", body=b"x")
            self.assertEqual(connection.getresponse().status, 413)

    def test_answer_pipelined_requests_in_order(self):
        with socket.create_connection((self.server.host, self.server.port), timeout=60) as client:
            paths = ["/models.json", self.tile(), "/nothing"] * 50
            client.sendall("".join(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n" for path in paths).encode())
            with client.makefile("rb") as stream:
                for path in paths:
                    status = int(stream.readline().split()[1])
                    length = 0
                    while (line := stream.readline()) != b"\r\n":
                        if line.lower().startswith(b"content-length:"):
                            length = int(line.split(b":")[1])
                    stream.read(length)
                    self.assertEqual(status, 404 if path == "/nothing" else 200)

    def test_are_made_once(self):
        path = next(name for name in self.files["painted"] if name.startswith("g/"))
        self.ask(f"/painted/{path}")
        before = self.server.metric("lodestream_http_contents_made_total")
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(self.ask(f"/painted/{path}")[0])) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(answers, [200] * 8)
        self.assertEqual(self.server.metric("lodestream_http_contents_made_total"), before)

    @unittest.skipUnless(shutil.which("curl"), "curl is not installed")
    def test_satisfy_curl(self):
        url = f"http://{self.server.address}"
        done = subprocess.run(["curl", "-sS", "--fail", "--compressed", f"{url}/gyroid/tileset.json", f"{url}{self.tile()}"],
                              capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        folder = self.folder / "gyroid"
        self.assertEqual(done.stdout, (folder / "tileset.json").read_bytes() + (folder / self.tile().split("/", 2)[2]).read_bytes())


class Tokens(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        folder = pathlib.Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        self.file = folder / "tokens"
        self.file.write_text("right/one never *\nfew never gyroid\nold 2001-01-01T00:00:00Z *\n")
        self.file.chmod(0o600)
        self.server = self.stack.enter_context(
            Served(MODELS / "gyroid.lode", MODELS / "painted.lode", "--token-file", self.file))

    def test_are_taken_from_the_header_or_the_path(self):
        path = "/gyroid/tileset.json"
        self.assertEqual(self.server.ask(path)[0], 401)
        self.assertEqual(self.server.ask(path)[1]["www-authenticate"], "Bearer")
        for headers in ({"Authorization": "Bearer right/one"}, {"Authorization": "bearer  few"}):
            status, head, _ = self.server.ask(path, **headers)
            self.assertEqual((status, head["cache-control"]), (200, "private, no-cache"))
        body = self.server.ask("/t/right%2Fone" + path)[2]
        self.assertEqual(self.server.ask("/t/few/gyroid/" + links_of(json.loads(body))[0])[0], 200)
        self.assertEqual(self.server.ask(path, "OPTIONS")[0], 204, "browsers send no token with a preflight request")

    def test_allow_only_their_models(self):
        few = {"Authorization": "Bearer few"}
        self.assertEqual(self.server.ask("/painted/tileset.json", **few)[0], 404)
        self.assertEqual([m["name"] for m in json.loads(self.server.ask("/models.json", **few)[2])["models"]], ["gyroid"])
        self.assertEqual([m["name"] for m in json.loads(self.server.ask("/t/few/models.json")[2])["models"]], ["gyroid"])
        self.assertEqual(len(json.loads(self.server.ask("/t/right%2Fone/models.json")[2])["models"]), 2)

    def test_that_are_wrong_are_answered_late_and_never_logged(self):
        seconds = []
        for token in ("secretwrong", "secretwrong", "secretwrong", "old"):
            began = time.monotonic()
            status, head, _ = self.server.ask("/t/" + token + "/models.json")
            seconds.append(time.monotonic() - began)
            self.assertEqual((status, head["connection"]), (401, "close"))
        for waited, least in zip(seconds, (0.05, 0.1, 0.2, 0.4)):  # a busy machine only adds to a wait
            self.assertGreaterEqual(waited, least, seconds)
        self.assertEqual(self.server.ask("/t/right%2Fone/models.json")[0], 200)
        self.assertIn("unauthorized", self.server.logged())
        for token in ("secretwrong", "right", "few", "old"):
            self.assertNotIn(token, self.server.logged())

    def test_can_be_replaced(self):
        self.file.write_text("new never *\n")
        self.server.process.send_signal(signal.SIGHUP)
        deadline = time.monotonic() + 60
        while self.server.ask("/models.json", Authorization="Bearer new")[0] != 200:
            self.assertLess(time.monotonic(), deadline)
        self.assertEqual(self.server.ask("/models.json", Authorization="Bearer few")[0], 401)


class Lives(unittest.TestCase):
    def test_follow_a_replaced_store(self):
        with tempfile.TemporaryDirectory() as name:
            store = pathlib.Path(name, "m.lode")
            shutil.copy(MODELS / "gyroid.lode", store)
            with Served(store) as server:
                old = server.ask("/m/tileset.json")
                links = [link for link in links_of(json.loads(old[2])) if link.startswith("g/")]
                self.assertEqual(server.ask("/m/" + links[0])[0], 200)
                shutil.copy(MODELS / "painted.lode", store.with_suffix(".new"))
                os.replace(store.with_suffix(".new"), store)
                server.process.send_signal(signal.SIGHUP)
                deadline = time.monotonic() + 60
                while server.ask("/m/tileset.json", If_None_Match=old[1]["etag"])[0] == 304:
                    self.assertLess(time.monotonic(), deadline)
                self.assertEqual(server.ask("/m/" + links[0])[0], 404, "a file of the old build")
                new = json.loads(server.ask("/m/tileset.json")[2])
                self.assertEqual(server.ask("/m/" + links_of(new)[0])[0], 200)

    def test_end_after_the_responses_that_run(self):
        with Served(MODELS / "gyroid.lode") as server:
            links = [link for link in links_of(json.loads(server.ask("/gyroid/tileset.json")[2])) if link.startswith("g/")]
            with contextlib.closing(server.connect()) as idle, socket.socket() as slow:
                ask(idle, "/models.json")
                slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                slow.settimeout(60)
                slow.connect((server.host, server.port))
                count = 1000  # their responses fit no socket's buffers
                slow.sendall(f"GET /gyroid/{links[0]} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() * count)
                first = slow.recv(100)
                server.process.send_signal(signal.SIGTERM)
                self.assertEqual(idle.sock.recv(1), b"", "an idle connection is closed at once")
                received = first
                while part := slow.recv(65536):
                    received += part
                heads = received.count(b"HTTP/1.1 200")
                self.assertGreaterEqual(heads, 1)
                self.assertLess(heads, count, "requests after the stop are not answered")
                last = received[received.rindex(b"HTTP/1.1 200"):]
                head, _, body = last.partition(b"\r\n\r\n")
                self.assertIn(b"Content-Length: %d\r\n" % len(body), head, "the last response is complete")
            self.assertEqual(server.process.wait(timeout=60), 0)

    def test_are_bounded_by_memory(self):
        with Served(MODELS / "asteroid2m.lode" if (MODELS / "asteroid2m.lode").exists() else MODELS / "gyroid.lode",
                    "--http-memory", "1MB") as server:
            model = json.loads(server.ask("/models.json")[2])["models"][0]["name"]
            todo, tiles = [f"/{model}/tileset.json"], []
            while todo and len(tiles) < 200:
                path = todo.pop()
                for link in links_of(json.loads(server.ask(path)[2])):
                    name = f"/{model}/" + link.removeprefix("../")
                    (todo if name.endswith(".json") else tiles).append(name)
            with contextlib.closing(server.connect()) as connection:
                statuses = {ask(connection, tile)[0] for tile in tiles}
            self.assertEqual(statuses, {200})
            self.assertLessEqual(server.metric("lodestream_http_cache_bytes"), 1e6)
            self.assertEqual(server.metric("lodestream_http_cache_limit_bytes"), 1e6)

    def test_go_on_when_a_store_is_damaged(self):
        with tempfile.TemporaryDirectory() as name:
            store = pathlib.Path(name, "m.lode")
            shutil.copy(MODELS / "gyroid.lode", store)
            with Served(store) as server:
                links = [link for link in links_of(json.loads(server.ask("/m/tileset.json")[2])) if link.startswith("g/")]
                with open(store, "r+b") as file:  # blobs begin after the header
                    file.seek(200)
                    file.write(bytes(os.path.getsize(store) // 2))
                statuses = [server.ask("/m/" + link)[0] for link in links]
                self.assertIn(500, statuses)
                self.assertEqual(server.metric('lodestream_model_damaged_blobs_total{model="m"}'), statuses.count(500))
                self.assertIn("m.lode", server.logged())
                self.assertNotIn(name, server.logged(), "logs name no folders")
                self.assertEqual(server.ask("/models.json")[0], 200)

    def test_count_in_the_metrics(self):
        with Served(MODELS / "gyroid.lode") as server:
            size = len(server.ask("/gyroid/tileset.json")[2])
            server.ask("/nothing")
            self.assertEqual(server.metric('lodestream_http_responses_total{status="200"}'), 1)
            self.assertEqual(server.metric('lodestream_http_responses_total{status="404"}'), 1)
            self.assertGreater(server.metric("lodestream_http_sent_bytes_total"), size)

    def test_share_the_rate_of_the_server(self):
        with Served(MODELS / "gyroid.lode", "--max-rate", "100KB") as server:
            links = [link for link in links_of(json.loads(server.ask("/gyroid/tileset.json")[2])) if link.startswith("g/")]
            began, size = time.monotonic(), 0
            with contextlib.closing(server.connect()) as connection:
                while size < 150_000:
                    size += len(ask(connection, "/gyroid/" + links[size % len(links)])[2])
            self.assertGreater(time.monotonic() - began, size / 100_000 - 0.5)

    def test_take_the_client_from_the_balancers_header(self):
        with Served(MODELS / "gyroid.lode", "--proxy-protocol", "--max-connections-per-address", "1") as server:
            def say(header):
                client = socket.create_connection((server.host, server.port), timeout=60)
                client.sendall(header + b"GET /models.json HTTP/1.1\r\nHost: localhost\r\n\r\n")
                with contextlib.suppress(ConnectionResetError):
                    return client, client.recv(12)
                return client, b""

            one, answer = say(b"PROXY TCP4 192.0.2.1 192.0.2.2 5000 80\r\n")
            self.assertEqual(answer, b"HTTP/1.1 200")
            same, answer = say(b"PROXY TCP4 192.0.2.1 192.0.2.2 5001 80\r\n")
            self.assertEqual(answer, b"HTTP/1.1 503", "the address has a connection")
            other, answer = say(b"PROXY TCP4 192.0.2.3 192.0.2.2 5002 80\r\n")
            self.assertEqual(answer, b"HTTP/1.1 200")
            without, answer = say(b"")
            self.assertEqual(answer, b"", "there is no header")
            for client in (one, same, other, without):
                client.close()

    def test_serve_clients_of_http_1_0(self):
        with Served(MODELS / "gyroid.lode") as server, socket.create_connection((server.host, server.port), timeout=60) as client:
            client.sendall(b"GET /models.json HTTP/1.0\r\n\r\n")
            received = b""
            while part := client.recv(65536):
                received += part
            self.assertIn(b"\r\nConnection: close\r\n", received)
            self.assertEqual(json.loads(received.partition(b"\r\n\r\n")[2])["models"][0]["name"], "gyroid")

    def test_need_tokens_and_tls_beyond_loopback(self):
        done = subprocess.run([str(BIN / "lodestreamd"), "serve", str(MODELS / "gyroid.lode"), "--listen", "127.0.0.1:0",
                               "--http", "0.0.0.0:0"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--token-file", done.stderr)

    def test_name_the_option_of_a_busy_port(self):
        with socket.create_server(("127.0.0.1", 0)) as busy:
            done = subprocess.run([str(BIN / "lodestreamd"), "serve", str(MODELS / "gyroid.lode"), "--listen", "127.0.0.1:0",
                                   "--http", f"127.0.0.1:{busy.getsockname()[1]}"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertIn("--http", done.stderr)

    @unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
    def test_are_encrypted_with_the_certificate_of_the_server(self):
        with tempfile.TemporaryDirectory() as name:
            key, certificate = (os.path.join(name, file) for file in ("key.pem", "cert.pem"))
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", certificate,
                            "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1"],
                           check=True, capture_output=True)
            with Served(MODELS / "gyroid.lode", "--tls-cert", certificate, "--tls-key", key) as server:
                context = ssl.create_default_context(cafile=certificate)
                with contextlib.closing(http.client.HTTPSConnection(server.host, server.port, context=context, timeout=60)) as client:
                    tileset = json.loads(ask(client, "/gyroid/tileset.json")[2])
                    tiles = [link for link in links_of(tileset) if link.startswith("g/")]
                    self.assertEqual(ask(client, "/gyroid/" + tiles[0])[2][:4], b"glTF")
                plain = server.ask  # a client without TLS is turned away
                with self.assertRaises((http.client.HTTPException, OSError)):
                    plain("/models.json")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
