#!/usr/bin/python3
"""Compares the time until a recognisable picture of a PLY file with that of f3d and MeshLab.

    bench_first_look.py BIN_DIR IN.ply... [--runs N]

Each run has its own Xvfb of 1280 x 800 and empty folders for settings and caches. The programs take turns.
The picture counts as recognisable when the middle of the screen first resembles its final state, which must
show detail. Prints the median of each program in seconds. Debian has f3d and meshlab; a program that is not
installed is left out.
"""
import argparse
import contextlib
import mmap
import os
import pathlib
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time

from rows import print_row

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "load"))
from processes import running  # noqa: E402

WIDTH, HEIGHT, MIDDLE = 1280, 800, 200  # pixels; MIDDLE: side of the compared square
POLL_S, STILL_S = 0.02, 2.5
LEAST_DETAIL = 0.03  # part of neighbouring pixels that differ
MOST_DIFFERENCE = 25  # mean difference of recognisable pictures, of 255


class Screen:
    """An Xvfb whose frame buffer is a file."""

    def __init__(self, stack):
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        reader, writer = os.pipe()
        command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-fbdir", self.folder]
        stack.enter_context(running(command, pass_fds=[writer], stderr=subprocess.DEVNULL))
        os.close(writer)
        with open(reader) as line:
            self.name = ":" + line.readline().strip()
        with open(self.folder / "Xvfb_screen0", "rb") as file:
            self.bytes = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)
        words = struct.unpack(">25I", self.bytes[:100])
        self.row_bytes = words[12]
        self.start = words[0] + 12 * words[19]

    def middle(self):
        """Returns one colour of the pixels in the middle, row by row."""
        left, top = (WIDTH - MIDDLE) // 2, (HEIGHT - MIDDLE) // 2
        rows = (self.start + (top + y) * self.row_bytes + 4 * left for y in range(MIDDLE))
        return b"".join(self.bytes[row + 1:row + 4 * MIDDLE:4] for row in rows)


def detail(picture):
    return sum(abs(a - b) > 2 for a, b in zip(picture, picture[1:])) / len(picture)


def difference(one, other):
    return sum(abs(a - b) for a, b in zip(one[::3], other[::3])) / len(one[::3])


def new_home(stack, screen):
    """Returns an environment with empty folders for settings and caches."""
    home = stack.enter_context(tempfile.TemporaryDirectory())
    (pathlib.Path(home) / "lodestream").mkdir(mode=0o700)
    (pathlib.Path(home) / "lodestream" / "help-seen").touch()  # the first help would cover the model
    return dict(os.environ, DISPLAY=screen.name, HOME=home, XDG_CACHE_HOME=home, XDG_CONFIG_HOME=home)


def first_look(command, longest_s):
    """Returns the seconds until the picture is recognisable."""
    with contextlib.ExitStack() as stack:
        screen = Screen(stack)
        environment = new_home(stack, screen)
        start = time.monotonic()
        stack.enter_context(running(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        seen = []
        while (now := time.monotonic() - start) < longest_s:
            picture = screen.middle()
            if not seen or seen[-1][1] != picture:
                seen.append((now, picture))
            elif now - seen[-1][0] > STILL_S and detail(picture) > LEAST_DETAIL:
                break
            time.sleep(POLL_S)
        last = seen[-1][1]
        if detail(last) <= LEAST_DETAIL:
            return float("nan")
        return next(at for at, picture in seen if difference(picture, last) < MOST_DIFFERENCE)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("inputs", nargs="+", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--longest", type=float, default=60, help="seconds that a program may take")
    options = parser.parse_args()
    size = f"{WIDTH}x{HEIGHT}"
    programs = {"lodestream": [options.bin_dir.resolve() / "lodestream", "view", "--size", size],
                "f3d": ["f3d", "--resolution", f"{WIDTH},{HEIGHT}"], "meshlab": ["meshlab"]}
    programs = {name: command for name, command in programs.items() if shutil.which(command[0])}
    for ply in options.inputs:
        times = {name: [] for name in programs}
        for _ in range(options.runs):
            for name, command in programs.items():
                times[name].append(first_look([*command, ply.resolve()], options.longest))
        print_row(file=ply.name, **{name: f"{statistics.median(all_s):.2f}" for name, all_s in times.items()})


if __name__ == "__main__":
    main()
