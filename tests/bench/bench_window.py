#!/usr/bin/python3
"""Measures frame times of the window while a model streams: bench_window.py BIN_DIR TARGET... [--link]

A window of 1280 x 720 on an Xvfb flies an orbit twice: parts arrive on the first lap; on the second nearly all are resident. It runs
with frame rate control (60 and 15 frames a second) and without (--pixels 1), and prints a row for each. Thresholds are in drawn pixels.

of_fit  99th percentile of a first-lap frame's time ÷ the time for its triangles by a line through the second lap's frames
of_aim  99th percentile of a first-lap frame's time ÷ its target

With --link, as root, stores are served over an emulated link of 10 Mbit/s and 25 ms one way; BIN_DIR then needs wan.
"""
import argparse
import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from rows import print_row

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "load"))
from processes import display, running  # noqa: E402
from stage import percentile  # noqa: E402
from surroundings import long_link  # noqa: E402

WAYS = (("60 frames a second", ["--fps", "60"]), ("15 frames a second", ["--fps", "15"]), ("1 pixel", ["--pixels", "1"]))


@contextlib.contextmanager
def beside(_, target):
    """Yields a target on this machine, and an empty prefix of commands for it."""
    yield target, []


@contextlib.contextmanager
def beyond_link(bin_dir, store):
    """Yields the URL of a store served over a long link, and the prefix of commands at its far end."""
    with long_link(bin_dir) as (near, far), \
            running([*near, bin_dir / "lodestreamd", "serve", store, "--listen", "10.9.0.1:7400", "--public", "--insecure"],
                    stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server:
        server.stdout.readline()
        yield f"lode://10.9.0.1/{pathlib.Path(store).stem}", far


def fly(bin_dir, target, prefix, options):
    with tempfile.TemporaryDirectory() as cache, display() as screen:
        environment = dict(os.environ, DISPLAY=screen, XDG_CACHE_HOME=cache)
        command = [*prefix, bin_dir / "lodestream", "view", target, "--laps", "2", "--json", "--cache", "off", "--size", "1280x720", *options]
        return json.loads(subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout)


def line_through(points):
    """Returns intercept and slope of a least-squares line of milliseconds over triangles."""
    count = len(points)
    mean_x, mean_y = (sum(point[i] for point in points) / count for i in (0, 1))
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in points) / spread if spread else 0
    return mean_y - slope * mean_x, slope


def frames_of(flown, lap):
    frames = [frame for frame in flown["frames"] if frame["lap"] == lap]
    if not frames:
        sys.exit(f"no frame of lap {lap + 1} was timed: a frame takes longer than the lap")
    return frames


def over_fit(flown):
    base, slope = line_through([(frame["triangles"], frame["work_ms"]) for frame in frames_of(flown, 1)])
    return percentile([frame["work_ms"] / (base + slope * frame["triangles"]) for frame in frames_of(flown, 0)], 0.99)


def over_aim(flown):
    frames = frames_of(flown, 0)
    if not all(frame["target_ms"] for frame in frames):
        return None
    return percentile([frame["work_ms"] / frame["target_ms"] for frame in frames], 0.99)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("targets", nargs="+")
    parser.add_argument("--link", dest="place", action="store_const", const=beyond_link, default=beside)
    arguments = parser.parse_args()
    for target in arguments.targets:
        for name, options in WAYS:
            with arguments.place(arguments.bin_dir.resolve(), target) as (address, prefix):
                flown = fly(arguments.bin_dir.resolve(), address, prefix, options)
            of_fit, of_aim = over_fit(flown), over_aim(flown)
            lap = flown["laps"][0]
            aim = {"aim_ms": lap["target_ms"]["p50"], "of_aim": of_aim} if of_aim else {}
            print_row(target=pathlib.PurePath(target).name, held=name, frames=lap["frames"], work_p50_ms=lap["work_ms"]["p50"],
                      work_p99_ms=lap["work_ms"]["p99"], **aim, of_fit=of_fit, triangles=lap["triangles"]["p50"], pixels=lap["scale"]["p50"] ** 2,
                      threshold_px=lap["threshold_px"]["p50"], upload_p99_ms=lap["upload_ms"]["p99"], upload_max_ms=lap["upload_ms"]["max"])


if __name__ == "__main__":
    main()
