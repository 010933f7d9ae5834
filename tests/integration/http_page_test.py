#!/usr/bin/env python3
"""Tests of the page that `lodestreamd serve --http` shows in a browser: http_page_test.py BIN MODELS

BIN has the programs, MODELS the stores of make_models.sh. Tests of the page's files are skipped if the programs were built
without client/web/dist.
"""
import gzip
import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from http_served import BIN, MODELS, Served

PAGE = pathlib.Path(__file__).resolve().parents[2] / "client" / "web" / "dist"
TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
         ".wasm": "application/wasm"}


def paths_of_files():
    return {"/" if path.name == "index.html" else f"/{path.name}": path for path in PAGE.iterdir() if path.is_file()}


@unittest.skipUnless((PAGE / "index.html").exists(), "the programs have no page")
class Page(unittest.TestCase):
    def test_consists_of_the_files_of_the_source_folder(self):
        with Served(MODELS / "gyroid.lode") as server:
            for path, file in paths_of_files().items():
                status, head, body = server.ask(path)
                self.assertEqual((status, body), (200, file.read_bytes()), path)
                self.assertEqual(head["content-type"], TYPES.get(file.suffix, head["content-type"]))
                self.assertEqual(head["cache-control"], "no-cache")
                self.assertEqual(server.ask(path, If_None_Match=head["etag"])[::2], (304, b""), path)
                self.assertEqual(server.ask(path, "HEAD")[1]["content-length"], str(len(body)))
                packed = server.ask(path, Accept_Encoding="gzip")
                self.assertEqual(gzip.decompress(packed[2]), body)
            self.assertEqual(server.ask("/nothing.js")[0], 404)

    def test_refers_to_its_own_files_only(self):
        links = re.findall(r'(?:src|href)="([^"]*)"', (PAGE / "index.html").read_text())
        self.assertTrue(links)
        for link in links:
            if not link.startswith(("data:", "#")):
                self.assertTrue((PAGE / link).is_file(), link)

    def test_needs_no_token(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = pathlib.Path(folder, "tokens")
            tokens.write_text("right never *\n")
            tokens.chmod(0o600)
            with Served(MODELS / "gyroid.lode", "--token-file", tokens) as server:
                for path, file in paths_of_files().items():
                    for prefix in ("", "/t/right", "/t/wrong"):
                        self.assertEqual(server.ask(prefix + path)[::2], (200, file.read_bytes()), prefix + path)
                self.assertEqual(server.ask("/models.json")[0], 401)
                self.assertEqual(server.ask("/t/right/models.json")[0], 200)
                self.assertNotIn("unauthorized", server.logged())


class Link(unittest.TestCase):
    def test_names_the_only_model(self):
        with Served(MODELS / "gyroid.lode") as server:
            self.assertEqual(server.link, f"http://{server.address}/#model=gyroid")
            deadline = time.monotonic() + 60
            while f"a browser shows the models at {server.link}\n" not in server.logged():  # a thread writes the log
                self.assertLess(time.monotonic(), deadline)

    def test_of_a_folder_of_stores_names_none(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("gyroid", "painted"):
                pathlib.Path(folder, f"{name}.lode").symlink_to(MODELS / f"{name}.lode")
            with Served(folder) as server:
                self.assertEqual(server.link, f"http://{server.address}/")
                self.assertEqual(server.ask("/")[0], 200)

    def test_encodes_names(self):
        with tempfile.TemporaryDirectory() as folder:
            store = pathlib.Path(folder, "a b&ü.lode")
            store.symlink_to(MODELS / "gyroid.lode")
            with Served(store) as server:
                self.assertEqual(server.link, f"http://{server.address}/#model=a%20b%26%C3%BC")

    def test_is_missing_without_http(self):
        with subprocess.Popen([BIN / "lodestreamd", "serve", MODELS / "gyroid.lode", "--listen", "127.0.0.1:0"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
            self.assertIsNone(json.loads(process.stdout.readline())["link"])
            process.terminate()


class Names(unittest.TestCase):
    """Host names that the server accepts. An attacker's name can resolve to loopback (DNS rebinding)."""

    def test_are_those_of_this_machine(self):
        with Served(MODELS / "gyroid.lode") as server:
            for host in ("localhost", f"localhost:{server.port}", server.address, "127.1.2.3", "[::1]:80"):
                self.assertEqual(server.ask("/models.json", Host=host)[0], 200, host)
            for host in ("rebound.example", f"rebound.example:{server.port}", "localhost.rebound.example", "10.0.0.1"):
                for path in ("/", "/models.json", "/gyroid/tileset.json", "/ws"):
                    status, _, body = server.ask(path, Host=host, Origin=f"http://{host}")
                    self.assertEqual(status, 421, f"{host} {path}")
                    self.assertIn(b"--public", body)

    def test_are_all_if_the_server_is_public(self):
        with Served(MODELS / "gyroid.lode", "--public") as server:
            self.assertEqual(server.ask("/models.json", Host="models.example")[0], 200)


class Models(unittest.TestCase):
    def test_have_places_and_sizes(self):
        with Served(MODELS / "gyroid.lode") as server:
            model, = json.loads(server.ask("/models.json")[2])["models"]
            least, greatest = model["box"]
            self.assertEqual(model["size"], [most - low for low, most in zip(least, greatest)])
            self.assertTrue(all(length > 0 for length in model["size"]))

    def test_come_with_the_native_port_where_it_is_reached(self):
        with Served(MODELS / "gyroid.lode", "--public") as server:
            self.assertEqual(json.loads(server.ask("/models.json")[2])["native"], {"port": int(server.native.rsplit(":", 1)[1]), "tls": False})
            self.assertIsNone(json.loads(server.ask("/models.json", Host="models.example")[2])["native"])

    def test_have_no_native_port_behind_a_balancer(self):
        with Served(MODELS / "gyroid.lode", "--proxy-protocol") as server, \
                socket.create_connection((server.host, server.port), timeout=60) as client, client.makefile("rb") as stream:
            client.sendall(b"PROXY TCP4 192.0.2.1 192.0.2.2 5000 80\r\n"
                           b"GET /models.json HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            self.assertIsNone(json.loads(stream.read().partition(b"\r\n\r\n")[2])["native"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
