"""Runs `lodestreamd serve --http` for the tests of HTTP, whose first two arguments are BIN and MODELS."""
import contextlib
import http.client
import json
import pathlib
import signal
import subprocess
import sys
import tempfile

BIN, MODELS = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])


class Served:
    """Runs `lodestreamd serve --http`. Leaving the `with` block sends SIGTERM and expects exit status 0."""

    def __init__(self, *arguments):
        command = [BIN / "lodestreamd", "serve", *arguments, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0",
                   "--metrics", "127.0.0.1:0"]
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, stderr=self.log, text=True)
        ready = json.loads(self.process.stdout.readline())
        self.address, self.health, self.link, self.native = (ready[key] for key in ("http", "metrics", "link", "listen"))
        self.host, self.port = self.address.rsplit(":", 1)[0], int(self.address.rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, failed, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM if not failed else signal.SIGKILL)
        status = self.process.wait(timeout=120)
        self.process.stdout.close()
        self.log.close()
        if not failed:
            assert status == 0, f"it ended with {status}"

    def logged(self):
        self.log.seek(0)
        return self.log.read()

    def connect(self):
        return http.client.HTTPConnection(self.host, self.port, timeout=60)

    def ask(self, path, method="GET", **headers):
        """Returns the response's status, its header fields in lower case, and its body."""
        with contextlib.closing(self.connect()) as connection:
            return ask(connection, path, method, **headers)

    def metric(self, name):
        with contextlib.closing(http.client.HTTPConnection(self.health, timeout=60)) as connection:
            connection.request("GET", "/metrics")
            lines = connection.getresponse().read().decode().splitlines()
        return float(next(line for line in lines if line.startswith(name + " ")).rsplit(" ", 1)[1])


def ask(connection, path, method="GET", **headers):
    connection.request(method, path, headers={name.replace("_", "-"): value for name, value in headers.items()})
    response = connection.getresponse()
    return response.status, {name.lower(): value for name, value in response.getheaders()}, response.read()


def export(store, folder):
    subprocess.run([str(BIN / "lodestreamd"), "export", str(store), "--tiles", str(folder), "--quiet"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def links_of(tileset):
    """All URIs in a tileset, relative to it."""
    found, todo = [], [tileset["root"]]
    while todo:
        tile = todo.pop()
        found += [tile["content"]["uri"]] if "content" in tile else []
        todo += tile.get("children", [])
    return found
