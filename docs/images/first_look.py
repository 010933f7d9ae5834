#!/usr/bin/env python3
"""Makes a film strip of the window's first ten seconds with a new PLY file: first_look.py BIN_DIR IN.ply OUT.jpg

The strip has five pictures a row, taken at TIMES_S after the start. Needs Xvfb and ImageMagick's convert.
"""
import contextlib
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent / "tests" / "bench"))
import bench_first_look as bench  # noqa: E402

TIMES_S = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10)
COLUMNS, SHRINK = 5, 4
QUALITY = "82"


def pictures_of(command):
    """Returns the screen at each of the times after the start of the program, as rows of blue, green, red and padding."""
    with contextlib.ExitStack() as stack:
        screen = bench.Screen(stack)
        environment = bench.new_home(stack, screen)
        start = time.monotonic()
        stack.enter_context(bench.running(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        pictures = []
        for at in TIMES_S:
            time.sleep(max(0, start + at - time.monotonic()))
            pictures.append(screen.bytes[screen.start:screen.start + bench.HEIGHT * screen.row_bytes])
    return screen.row_bytes, pictures


def shrink(picture, row_bytes):
    """Returns rows of red, green and blue, each the mean of SHRINK x SHRINK pixels."""
    for top in range(0, bench.HEIGHT, SHRINK):
        rows = [picture[y * row_bytes:y * row_bytes + 4 * bench.WIDTH] for y in range(top, top + SHRINK)]
        small = bytearray()
        for left in range(0, 4 * bench.WIDTH, 4 * SHRINK):
            for channel in (2, 1, 0):
                total = sum(sum(row[left + channel:left + 4 * SHRINK:4]) for row in rows)
                small.append(total // SHRINK ** 2)
        yield bytes(small)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__.split("\n\n")[0])
    bin_dir, ply, out = map(pathlib.Path, sys.argv[1:])
    size = f"{bench.WIDTH}x{bench.HEIGHT}"
    row_bytes, pictures = pictures_of([bin_dir.resolve() / "lodestream", "view", "--size", size, ply])
    small = [list(shrink(picture, row_bytes)) for picture in pictures]
    strips = [b"".join(map(b"".join, zip(*small[at:at + COLUMNS]))) for at in range(0, len(small), COLUMNS)]
    width, height = COLUMNS * bench.WIDTH // SHRINK, len(strips) * bench.HEIGHT // SHRINK
    pixels = b"P6\n%d %d\n255\n" % (width, height) + b"".join(strips)
    subprocess.run(["convert", "ppm:-", "-quality", QUALITY, f"jpeg:{out}"], input=pixels, check=True)


if __name__ == "__main__":
    main()
