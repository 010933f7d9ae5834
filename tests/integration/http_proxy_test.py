#!/usr/bin/env python3
"""Tests of `lodestreamd serve --http` behind nginx: http_proxy_test.py BIN MODELS

BIN has the programs, MODELS the stores of make_models.sh. Without nginx the tests are skipped.
"""
import contextlib
import http.client
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

from http_served import MODELS, Served, ask, links_of


@unittest.skipUnless(shutil.which("nginx") or os.path.exists("/usr/sbin/nginx"), "nginx is not installed")
class BehindNginx(unittest.TestCase):
    CONFIG = """
        daemon off; pid {folder}/nginx.pid; error_log {folder}/error.log;
        events {{ worker_connections 256; }}
        http {{
          access_log off;
          client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy; fastcgi_temp_path {folder}/f;
          uwsgi_temp_path {folder}/u; scgi_temp_path {folder}/s;
          proxy_cache_path {folder}/cache keys_zone=tiles:1m;
          upstream lodestream {{ server {server}; keepalive 16; }}
          server {{
            listen 127.0.0.1:{port}{listen};
            {tls}
            location /models/ {{
              proxy_pass http://lodestream/;
              proxy_http_version 1.1;
              proxy_set_header Connection "";
              proxy_cache tiles;
            }}
            location = /models/ws {{
              proxy_pass http://lodestream/ws;
              proxy_http_version 1.1;
              proxy_set_header Upgrade $http_upgrade;
              proxy_set_header Connection upgrade;
              proxy_set_header Host $http_host;
              proxy_read_timeout 150s;
              proxy_buffering off;
            }}
          }}
        }}"""

    @contextlib.contextmanager
    def nginx(self, server, http2=None):
        """Yields the port of an nginx in front of a server."""
        with tempfile.TemporaryDirectory() as name, socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
            free.close()
            os.chmod(name, 0o755)
            config = pathlib.Path(name, "nginx.conf")
            tls = f"ssl_certificate {http2}/cert.pem; ssl_certificate_key {http2}/key.pem;" if http2 else ""
            config.write_text(self.CONFIG.format(folder=name, server=server.address, port=port, tls=tls,
                                                 listen=" ssl http2" if http2 else ""))
            program = shutil.which("nginx") or "/usr/sbin/nginx"
            process = subprocess.Popen([program, "-c", str(config), "-e", os.path.join(name, "error.log")],
                                       stderr=subprocess.DEVNULL)
            try:
                deadline = time.monotonic() + 60
                while True:
                    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1):
                        break
                    self.assertLess(time.monotonic(), deadline)
                    self.assertIsNone(process.poll())
                yield port
            finally:
                process.send_signal(signal.SIGQUIT)
                process.wait(timeout=60)

    def test_the_files_are_the_same_and_cached(self):
        with Served(MODELS / "gyroid.lode", "--public") as server, self.nginx(server) as port:
            direct = server.ask("/gyroid/tileset.json")[2]
            tile = "gyroid/" + next(link for link in links_of(json.loads(direct)) if link.startswith("g/"))
            with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=60)) as client:
                self.assertEqual(ask(client, "/models/gyroid/tileset.json")[2], direct)
                status, head, body = ask(client, f"/models/{tile}")
                self.assertEqual((status, body), (200, server.ask("/" + tile)[2]))
                responses = server.metric('lodestream_http_responses_total{status="200"}')
                self.assertEqual(ask(client, f"/models/{tile}")[2], body)
                self.assertEqual(server.metric('lodestream_http_responses_total{status="200"}'), responses)
                self.assertEqual(ask(client, f"/models/{tile}", If_None_Match=head["etag"])[0], 304)
                self.assertEqual(ask(client, "/models/nothing")[0], 404)

    def test_websockets_pass(self):
        with Served(MODELS / "gyroid.lode") as server, self.nginx(server) as port, \
                socket.create_connection(("127.0.0.1", port), timeout=60) as client:
            client.sendall(f"GET /models/ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\n"
                           "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode())
            with client.makefile("rb") as stream:
                self.assertIn(b" 101 ", stream.readline())
                while stream.readline() != b"\r\n":
                    pass
                client.sendall(b"\x89\x82\0\0\0\0hi")
                self.assertEqual(stream.read(4), b"\x8a\x02hi", "an answer to Ping")

    @unittest.skipUnless(shutil.which("curl") and shutil.which("openssl"), "curl or openssl is not installed")
    def test_browsers_use_http_2(self):
        if b"HTTP2" not in subprocess.run(["curl", "--version"], capture_output=True).stdout:
            self.skipTest("this curl knows no HTTP/2")
        with tempfile.TemporaryDirectory() as name, Served(MODELS / "gyroid.lode", "--public") as server:
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", f"{name}/key.pem",
                            "-out", f"{name}/cert.pem", "-days", "2", "-subj", "/CN=localhost"], check=True, capture_output=True)
            with self.nginx(server, name) as port:
                done = subprocess.run(["curl", "-sSk", "--http2", "-w", "%{http_version}",
                                       f"https://127.0.0.1:{port}/models/gyroid/tileset.json"], capture_output=True, timeout=60)
            self.assertEqual(done.stdout, server.ask("/gyroid/tileset.json")[2] + b"2", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
