#!/usr/bin/env python3
"""Measures how long resting cameras wait: over loopback, over an emulated link, and over this link through
HAProxy: bench_link.py BIN_DIR STORE, as root.

For each camera and each order of requests, `lodestream replay` starts without a cache and ends when the cut
has converged. Prints medians over --runs, from the start of the connection. `allowed_ms` is 1.15 × the link's
own time for the bytes, plus four round trips. BIN_DIR holds both programs, and wan. Server and client run at
real-time priority.
"""
import argparse
import contextlib
import itertools
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

from rows import print_row

sys.path.append(str(pathlib.Path(__file__).parent.parent / "load"))
from processes import running  # noqa: E402
from surroundings import long_link, plain_haproxy  # noqa: E402

REAL_TIME = ["chrt", "-r", "1"]
DELAY_MS, MBIT_S, PORT = 25, 10, 7466
CAMERAS = {"far": (4.0, 0), "mid": (1.7, 0), "close": (1.12, 0.6)}  # eye and target, in half sides from the middle
SEND = f"""
import socket, sys
listener = socket.create_server(("0.0.0.0", {PORT + 1}))
print("ready", flush=True)
listener.accept()[0].sendall(bytes(8 << 20))
"""
RECEIVE = f"""
import socket, time
line, got, start = socket.create_connection(("10.9.0.1", {PORT + 1})), 0, None
while part := line.recv(1 << 16):
    start = start or time.monotonic()
    got += len(part)
print(got / (time.monotonic() - start))
"""


def goodput(near, far):
    """Returns the bytes per second of one bulk connection."""
    with running([*near, *REAL_TIME, sys.executable, "-c", SEND], stdout=subprocess.PIPE, text=True) as sender:
        sender.stdout.readline()
        return float(subprocess.run([*far, *REAL_TIME, sys.executable, "-c", RECEIVE], check=True, capture_output=True, text=True).stdout)


def camera(box, name, folder):
    """Writes a camera beside the box's centre."""
    eye, target = CAMERAS[name]
    middle = [(low + high) / 2 for low, high in zip(box["min"], box["max"])]
    side = max(high - low for low, high in zip(box["min"], box["max"])) / 2
    key = {"t": 0, "eye": [middle[0], middle[1], middle[2] + eye * side], "target": [middle[0] + target * side, *middle[1:]], "up": [0, 1, 0]}
    file = pathlib.Path(folder, name + ".json")
    file.write_text(json.dumps({"fov_y_deg": 45, "keys": [key]}))
    return file


def measure(program, address, store, path, order, prefix, options):
    """Returns medians of the numbers that replay prints."""
    command = [*prefix, *REAL_TIME, program, "replay", f"lode://{address}/{store.stem}", "--camera", path, "--order", order, "--fps", "250",
               "--cache", "off", "--json", *options.replay]
    runs = [json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout) for _ in range(options.runs)]
    for run in runs:
        run.update({f"px{threshold}": run["reached_px_ms"][threshold] for threshold in "421"})
    return {key: statistics.median(run[key] for run in runs) for key in
            ("first_image_ms", "px4", "px2", "px1", "bytes_received", "final_cut_bytes", "peak_rss_bytes")} | {"holes": sum(run["holes"] for run in runs)}


def await_answer(ask, server):
    while subprocess.run(ask, capture_output=True).returncode != 0:
        if server.poll() is not None:
            sys.exit("the server has ended")
        time.sleep(0.1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--initcwnd", type=int, help="segments that the server's system sends before the first acknowledgement (its default: 10)")
    parser.add_argument("--replay", nargs="*", default=[], help="more options of replay")
    options = parser.parse_args()
    info = json.loads(subprocess.run([options.bin_dir / "lodestreamd", "info", options.store, "--json"], check=True, capture_output=True).stdout)
    with contextlib.ExitStack() as ending, tempfile.TemporaryDirectory() as folder:
        near, far = ending.enter_context(long_link(options.bin_dir, DELAY_MS, MBIT_S))
        if options.initcwnd:
            subprocess.run([*near, "ip", "route", "change", "10.9.0.0/24", "dev", "em0", "initcwnd", str(options.initcwnd)], check=True)
        bytes_s = goodput(near, far)
        ending.enter_context(plain_haproxy(folder, f"10.9.0.1:{PORT + 2}", f"10.9.0.1:{PORT}", [*near, *REAL_TIME]))
        emulated = f"{MBIT_S} Mbit/s"
        for link, host, port, there, here in (("loopback", "127.0.0.1", PORT, [], []), (emulated, "10.9.0.1", PORT, near, far),
                                              (f"{emulated}, HAProxy", "10.9.0.1", PORT + 2, near, far)):
            listen = [*there, *REAL_TIME, options.bin_dir / "lodestreamd", "serve", options.store, "--listen", f"{host}:{PORT}", "--public", "--insecure"]
            with running(listen, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
                await_answer([*here, options.bin_dir / "lodestream", "list", f"lode://{host}:{port}", "--timeout", "2"], server)
                for name, order in itertools.product(CAMERAS, ("best", "first-come")):
                    row = measure(options.bin_dir / "lodestream", f"{host}:{port}", options.store, camera(info["box"], name, folder), order, here, options)
                    allowed = {"allowed_ms": 1150 * row["bytes_received"] / bytes_s + 4 * 2 * DELAY_MS} if here else {}
                    print_row(link=link, camera=name, order=order, first_image_ms=row["first_image_ms"], px4_ms=row["px4"], px2_ms=row["px2"],
                              px1_ms=row["px1"], **allowed, received_kb=row["bytes_received"] / 1e3,
                              of_cut=row["bytes_received"] / row["final_cut_bytes"], holes=row["holes"], peak_mb=row["peak_rss_bytes"] / 1e6)
    print_row(link=emulated, what="one bulk connection", goodput_mb_s=bytes_s / 1e6)


if __name__ == "__main__":
    main()
