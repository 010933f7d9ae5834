#!/usr/bin/env python3
"""Measures the errors that a moving camera sees over an emulated link of 25 ms one way: bench_moving.py WHAT
BIN_DIR STORE [OTHER_STORE], as root.

leaps   turns and leaps beyond the margin, at 10 and 60 frames a second: holes, and frames that show a fallback
paths   an orbit, walks along the surface and fast walks, with and without prefetch
faults  a walk without a fault, with a killed server, a stopped server, and a model replaced by OTHER_STORE, another build of the
        same model; with 1 % of the packets lost, at 20 KB/s, and with both. Exits with 1 unless each run converges without a hole.

BIN_DIR holds both programs, and wan. Server and client run at real-time priority.
"""
import argparse
import contextlib
import json
import math
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from bench_link import DELAY_MS, MBIT_S, PORT, REAL_TIME, await_answer
from rows import print_row

sys.path.append(str(pathlib.Path(__file__).parent.parent / "load"))
from processes import start  # noqa: E402
from surroundings import long_link  # noqa: E402

SLOW_MBIT_S = 0.16  # 20 KB/s
LEAP_S = 0.5
FAULT_S = 4  # after the start


def turned(radius, degrees, height=0.2):
    """Returns an orbit around the centre. Lengths are in half sides of the box."""
    angle = math.radians(degrees)
    return [radius * math.sin(angle), radius * height, radius * math.cos(angle)]


def orbit():
    return [(2.5 * i, turned(3.2 - 0.2 * i, 45 * i), [0, 0, 0]) for i in range(9)]


def walks(count, walk_s, rest_s):
    """Returns walks along the surface with rests. Each walk covers a twelfth of the way around."""
    keys, t = [], 0
    for i in range(count):
        for at, when in ((i, t), (i + 1, t + walk_s)):
            keys.append((when, turned(1.25, 30 * at), turned(0.8, 30 * at + 40)))
        t += walk_s + rest_s
    return keys


def leaps(seconds):
    """Returns leaps between random places around the model. The camera looks at random points of the model."""
    chance = random.Random(1)
    def place(least, most):
        direction = [chance.gauss(0, 1) for _ in range(3)]
        return [chance.uniform(least, most) * part / math.hypot(*direction) for part in direction]
    return [(LEAP_S * i, place(1.05, 3), place(0, 0.8)) for i in range(int(seconds / LEAP_S))]


def write_path(file, box, keys):
    middle = [(low + high) / 2 for low, high in zip(box["min"], box["max"])]
    half = max(high - low for low, high in zip(box["min"], box["max"])) / 2
    true = lambda place: [m + half * p for m, p in zip(middle, place)]
    file.write_text(json.dumps({"fov_y_deg": 45, "keys": [{"t": t, "eye": true(eye), "target": true(target), "up": [0, 1, 0]}
                                                           for t, eye, target in keys]}))
    return file


class Server:
    """A server that the benchmark stops, kills or reloads."""

    def __init__(self, options, folder, prefix):
        self.store = pathlib.Path(folder, options.store.name)
        shutil.copy(options.store, self.store)
        self.other = options.other
        self.command = [*prefix, *REAL_TIME, options.bin_dir / "lodestreamd", "serve", self.store, "--listen", f"10.9.0.1:{PORT}", "--public", "--insecure"]
        self.quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = start(self.command, **self.quiet)

    def end(self, how, away_s=0):
        self.process.send_signal(how)
        self.process.wait()
        time.sleep(away_s)
        self.process = start(self.command, **self.quiet)

    def replace(self):
        new = self.store.with_suffix(".new")
        shutil.copy(self.other, new)
        new.rename(self.store)
        self.process.send_signal(signal.SIGHUP)

    def close(self):
        self.process.terminate()
        self.process.wait()


@contextlib.contextmanager
def served(options, folder, **link):
    """Yields the server, and a function that runs replay with more options."""
    with long_link(options.bin_dir, DELAY_MS, **link) as (near, far):
        server = Server(options, folder, near)
        program, url = options.bin_dir / "lodestream", f"lode://10.9.0.1:{PORT}/{options.store.stem}"
        try:
            await_answer([*far, program, "list", f"lode://10.9.0.1:{PORT}", "--timeout", "5"], server.process)
            def replay(path, *more, meanwhile=lambda: None):
                command = [*far, *REAL_TIME, program, "replay", url, "--camera", path, "--cache", "off", "--json", *map(str, more), *options.replay]
                player = start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                meanwhile()
                said, complaint = player.communicate()
                return json.loads(said) if said else sys.exit(f"{' '.join(map(str, command))}: {complaint}")
            yield server, replay
        finally:
            server.close()


def measure_leaps(options, folder, box):
    path = write_path(pathlib.Path(folder, "leaps.json"), box, leaps(options.seconds))
    with served(options, folder, mbit_s=MBIT_S) as (_, replay):
        for fps in (10, 60):
            run = replay(path, "--fps", fps)
            frame = run["frame_ms"]
            print_row(path="leaps", rate=f"{fps} frames a second", frames=run["frames"], holes=run["holes"], fallback_frames=run["fallback_frames"],
                      frame_p50_ms=frame["p50"], frame_p99_ms=frame["p99"], received_mb=run["bytes_received"] / 1e6, peak_mb=run["peak_rss_bytes"] / 1e6)


def measure_paths(options, folder, box):
    with served(options, folder, mbit_s=MBIT_S) as (_, replay):
        for name, keys in (("orbit", orbit()), ("walk", walks(6, 2, 3)), ("fast", walks(8, 1, 1.5))):
            path = write_path(pathlib.Path(folder, name + ".json"), box, keys)
            for ahead in ([], ["--no-prefetch"]):
                run = replay(path, "--fps", 60, *ahead)
                above, prefetch = run["seconds_above_px"], run["prefetch"]
                used = {} if ahead else {"hit_rate": prefetch["hit_rate"] or 0, "wasted_of_received": prefetch["wasted_bytes"] / run["bytes_received"]}
                print_row(path=name, prefetch="no" if ahead else "yes", above_px4_s=above["4"], above_px2_s=above["2"], above_px1_s=above["1"], **used,
                          received_kb=run["bytes_received"] / 1e3, holes=run["holes"])


FAULTS = {
    "none": lambda server: None,
    "killed, back after 3 s": lambda server: server.end(signal.SIGKILL, 3),
    "stopped, back after 2 s": lambda server: server.end(signal.SIGTERM, 2),
    "model replaced": Server.replace,
}


def measure_faults(options, folder, box):
    path = write_path(pathlib.Path(folder, "walk.json"), box, walks(3, 2, 2))
    good = True
    links = ({"mbit_s": MBIT_S, "loss_percent": 1}, {"mbit_s": SLOW_MBIT_S}, {"mbit_s": SLOW_MBIT_S, "loss_percent": 1})
    for link in links:
        for fault, happen in FAULTS.items():
            with served(options, folder, **link) as (server, replay):
                def meanwhile():
                    time.sleep(FAULT_S)
                    happen(server)
                run = replay(path, "--fps", 60, "--timeout", options.seconds, meanwhile=meanwhile)
            good &= run["converged"] and run["holes"] == 0
            after = {"converged_s": run["converged_ms"] / 1e3} if run["converged"] else {}
            print_row(link=f"{link['mbit_s'] * 125:.0f} KB/s, {link.get('loss_percent', 0)} % lost", fault=fault, **after, holes=run["holes"],
                      received_kb=run["bytes_received"] / 1e3, fallback_frames=run["fallback_frames"], above_px2_s=run["seconds_above_px"]["2"])
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["leaps", "paths", "faults"])
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("other", type=pathlib.Path, nargs="?", help="for faults")
    parser.add_argument("--seconds", type=float, default=120, help="of leaps, and that a run after its path may take")
    parser.add_argument("--replay", nargs=argparse.REMAINDER, default=[], help="more options of replay; the last")
    options = parser.parse_args()
    if options.what == "faults" and options.other is None:
        parser.error("faults needs OTHER_STORE")
    info = json.loads(subprocess.run([options.bin_dir / "lodestreamd", "info", options.store, "--json"], check=True, capture_output=True).stdout)
    with tempfile.TemporaryDirectory() as folder:
        measure = {"leaps": measure_leaps, "paths": measure_paths, "faults": measure_faults}[options.what]
        if measure(options, folder, info["box"]) is False:
            sys.exit("a run did not end converged, or had a hole")


if __name__ == "__main__":
    main()
