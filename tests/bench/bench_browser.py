#!/usr/bin/env python3
"""Waits of the page in a browser beside `lodestream fetch` and other pages: bench_browser.py BIN_DIR STORE, as root.

    bench_browser.py BIN_DIR STORE [--peer NAME=FOLDER[?QUERY]]... [--runs N] [--json]

For each camera of bench_link.py, over loopback and over the emulated link, each client starts without a cache and ends when its
picture has an error of one pixel. The browser has loaded the page's files before, and is new in each run. Prints medians, from the
request for the model.

A peer's FOLDER has an index.html that sets `window.peer` once its own files are loaded: `show({tileset, eye, target, up, fov, px})`
starts it, and `state()` returns {settled, first_ms, settled_ms, triangles, error_px}. `tileset` is the model's on the same server;
the folder's files come from an nginx beside the server. BIN_DIR holds both programs, and wan. Needs Chromium and its driver.
"""
import argparse
import contextlib
import ctypes
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

from bench_link import CAMERAS, DELAY_MS, MBIT_S, PORT, camera
from rows import print_row

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path += [str(TESTS / "load"), str(TESTS / "integration")]
import browser  # noqa: E402
from processes import running  # noqa: E402
from surroundings import long_link  # noqa: E402

WIDTH, HEIGHT, PIXELS = 1280, 720, 1
CLONE_NEWNET = 0x40000000
WAITED_S = 300

# Opens a model in the loaded page and keeps the times. The figures are those of the picture once hidden parts are there too.
OPEN_MODEL = """
const before = lodestream.viewer(), start = performance.now(), times = {};
location.hash = arguments[0];
const timer = setInterval(() => {
  const state = lodestream.viewer() === before ? {} : lodestream.state();
  if (!state.converged) return;
  times.settled_ms ??= performance.now() - start;
  if (!state.settled) return;
  clearInterval(timer);
  window.times = {first_ms: state.first_picture_ms - start, ...state, ...times};
}, 4);
"""

SHOW_IN_PEER = """
performance.setResourceTimingBufferSize(10000);
performance.clearResourceTimings();
window.start = performance.now();
peer.show(arguments[0]);
"""

# Adds what had arrived when the picture was complete.
PEER_TIMES = """
const times = peer.state(), end = window.start + times.settled_ms;
const arrived = performance.getEntriesByType('resource').filter((entry) => entry.responseEnd <= end);
return {...times, requests: arrived.length, received_bytes: arrived.reduce((sum, entry) => sum + entry.transferSize, 0)};
"""


@contextlib.contextmanager
def inside(namespace):
    """Moves this process, and those that it starts, into a network namespace."""
    def enter(path):
        with open(path) as opened:
            if ctypes.CDLL(None, use_errno=True).setns(opened.fileno(), CLONE_NEWNET) != 0:
                raise OSError(ctypes.get_errno(), f"cannot enter {path}")
    with open("/proc/self/ns/net") as own:
        enter(f"/run/netns/{namespace}")
        try:
            yield
        finally:
            enter(f"/proc/self/fd/{own.fileno()}")


@contextlib.contextmanager
def nginx(folder, listen, root, prefix):
    config = pathlib.Path(folder, "nginx.conf")
    config.write_text(f"""
        daemon off; master_process off; pid {folder}/nginx.pid; error_log {folder}/error.log; events {{ }}
        http {{ include /etc/nginx/mime.types; access_log off; server {{ listen {listen}; root {root}; }} }}""")
    with running([*prefix, "nginx", "-c", config, "-e", f"{folder}/error.log"]) as process:
        yield process


class Server:
    """Runs `lodestreamd serve --http` on a host, and nginx for the pages of peers."""

    def __init__(self, options, stack, host, prefix):
        self.native, self.web, self.peers = f"{host}:{PORT}", f"{host}:{PORT + 3}", {}
        command = [*prefix, options.bin_dir / "lodestreamd", "serve", options.store, "--listen", self.native, "--http", self.web,
                   "--public", "--insecure"]
        server = stack.enter_context(running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True))
        server.stdout.readline()
        for number, peer in enumerate(options.peer, PORT + 4):
            name, _, place = peer.partition("=")
            root, _, query = place.partition("?")
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            stack.enter_context(nginx(folder, f"{host}:{number}", pathlib.Path(root).resolve(), prefix))
            self.peers[name] = f"http://{host}:{number}/?{query}"


def fetched(options, server, path):
    command = [options.bin_dir / "lodestream", "fetch", f"lode://{server.native}/{options.store.stem}", "--camera", path, "--size",
               f"{WIDTH}x{HEIGHT}", "--pixels", str(PIXELS), "--cache", "off", "--json"]
    run = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {"first_ms": run["first_image_ms"], "settled_ms": run["converged_ms"], "received_bytes": run["bytes_received"],
            "triangles": run["triangles"], "error_px": run["max_error_px"]}


def shown_by_page(options, server, view):
    vectors = "&".join(f"{name}={','.join(map(repr, view[name]))}" for name in ("eye", "target", "up"))
    with browser.Browser(WIDTH, HEIGHT) as window:
        window.open(f"http://{server.web}/#model=-")  # there is none: the page and its core start
        window.wait_for("lodestream.viewer()?.session?.stream.failure")
        window.run(OPEN_MODEL, f"#model={options.store.stem}&{vectors}&fov={view['fov']}&px={PIXELS}")
        return window.wait_for("window.times", WAITED_S)


def shown_by_peer(options, server, url, view):
    with browser.Browser(WIDTH, HEIGHT) as window:
        window.open(url)
        window.wait_for("Boolean(window.peer)")
        window.run(SHOW_IN_PEER, {"tileset": f"http://{server.web}/{options.store.stem}/tileset.json", "px": PIXELS, **view})
        window.wait_for("peer.state().settled", WAITED_S)
        return window.run(PEER_TIMES)


def measure(options, server, folder, name):
    """Returns a row of figures for each client."""
    path = camera(options.info["box"], name, folder)
    parsed = json.loads(path.read_text())
    view = {"fov": parsed["fov_y_deg"], **parsed["keys"][0]}
    clients = {"fetch": lambda: fetched(options, server, path), "page": lambda: shown_by_page(options, server, view)}
    for peer, url in server.peers.items():
        clients[peer] = lambda url=url: shown_by_peer(options, server, url, view)
    runs = {client: [] for client in clients}
    for _ in range(options.runs):
        for client, show in clients.items():
            runs[client].append(show())
    median = lambda client, what: statistics.median(run.get(what) or 0 for run in runs[client])
    return [{"client": client, "first_ms": median(client, "first_ms"), "one_px_ms": median(client, "settled_ms"),
             "received_kb": median(client, "received_bytes") / 1e3,
             "of_fetch": median(client, "received_bytes") / median("fetch", "received_bytes"),
             "requests": median(client, "requests"), "triangles": median(client, "triangles"),
             "error_px": median(client, "error_px")} for client in clients]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("--peer", action="append", default=[], metavar="NAME=FOLDER[?QUERY]")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--links", nargs="+", choices=("loopback", "slow"), default=["loopback", "slow"])
    parser.add_argument("--cameras", nargs="+", choices=CAMERAS, default=list(CAMERAS))
    parser.add_argument("--json", action="store_true", help="print rows for compare.py")
    options = parser.parse_args()
    if browser.missing():
        sys.exit(f"there is no {browser.missing()}")
    info = [options.bin_dir / "lodestreamd", "info", options.store, "--json"]
    options.info = json.loads(subprocess.run(info, check=True, capture_output=True).stdout)
    rows = []
    for link in options.links:
        with contextlib.ExitStack() as ending, tempfile.TemporaryDirectory() as folder:
            host, prefix = "127.0.0.1", []
            if link == "slow":
                host, (prefix, far) = "10.9.0.1", ending.enter_context(long_link(options.bin_dir, DELAY_MS, MBIT_S))
            server = Server(options, ending, host, prefix)
            if link == "slow":
                ending.enter_context(inside(far[-1]))
            for name in options.cameras:
                for row in measure(options, server, folder, name):
                    rows.append({"link": link, "camera": name, **row})
                    if options.json:
                        print_row(**rows[-1])
    if not options.json:
        print_table(rows)


def print_table(rows):
    cells = [list(rows[0])] + [[f"{value:.5g}" if isinstance(value, float) else str(value) for value in row.values()] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    for line in cells:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())


if __name__ == "__main__":
    main()
