"""A lodestreamd of the build under test, for tests in Python: TEST.py BIN_DIR MODELS_DIR SOURCE_DIR [TEST ...]"""
import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request

import lodestream_generated as wire
from read_model import HEADER, Connection, Reader

BIN, MODELS, SOURCE = (os.path.abspath(sys.argv.pop(1)) for _ in range(3))
STORE = os.path.join(MODELS, "painted.lode")


class Daemon:
    """Runs lodestreamd serve on free loopback ports. The end of the `with` ends the server by SIGTERM, and expects exit status
    0."""

    def __init__(self, *arguments, shell="", **options):
        command = [os.path.join(BIN, "lodestreamd"), "serve", *arguments, "--listen", "127.0.0.1:0", "--metrics", "127.0.0.1:0"]
        if shell:
            command = ["sh", "-c", f'{shell} exec "$0" "$@"', *command]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, **options)
        ready = json.loads(self.process.stdout.readline())
        self.address, self.health, self.models, self.skipped = (ready[key] for key in ("listen", "metrics", "models", "skipped"))
        self.http = ready["http"]

    def __enter__(self):
        return self

    def __exit__(self, failed, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM if not failed else signal.SIGKILL)
        self.status = self.process.wait(timeout=300)
        self.process.stdout.close()
        if not failed:
            assert self.status == 0, f"it ended with {self.status}"

    def ask(self, path):
        try:
            with urllib.request.urlopen(f"http://{self.health}{path}", timeout=10) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as error:
            with error:
                return error.code, ""

    def metric(self, name):
        found = re.search(rf"^{re.escape(name)} (\S+)$", self.ask("/metrics")[1], re.M)
        return float(found.group(1))

    def open(self, model="painted"):
        """Opens a model. Returns the connection and the message Opened."""
        with contextlib.ExitStack() as failing:
            connection = failing.enter_context(contextlib.closing(Connection(self.address)))
            opened, most = connection.open(model)
            failing.pop_all()
        return connection, opened, most

    def read_whole(self, model="painted"):
        connection, opened, most = self.open(model)
        with contextlib.closing(connection):
            return Reader(connection, opened, most).run()


def refusal(address):
    """Connects and returns the Error that the server sends before the client sends anything."""
    host, port = address.rsplit(":", 1)
    with socket.create_connection((host, int(port)), timeout=120) as client:
        size, kind, *_ = HEADER.unpack(client.recv(HEADER.size, socket.MSG_WAITALL))
        assert kind == 11, f"a frame of type {kind}"
        return wire.Error.GetRootAs(client.recv(size, socket.MSG_WAITALL))


def requests(count, request_class=0):
    """Returns `count` requests, each for one of the first blobs of STORE."""
    changes = [wire.RequestChangeT() for _ in range(count)]
    for number, change in enumerate(changes, 1):
        change.request, change.blob, change.requestClass = number, 1 + number % 90, request_class
    return changes
