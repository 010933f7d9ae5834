#!/usr/bin/env python3
"""Makes pictures of the window with its panel, driven by keys and a pointer: window_pictures.py BIN_DIR MODELS_DIR

Shows MODELS_DIR/terrain.lode and writes into this script's folder. Needs Xvfb and xdotool; make.sh calls it.
"""
import pathlib
import struct
import sys
import tempfile
import time
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent / "tests" / "integration"))
import driven_window  # noqa: E402

MODEL = driven_window.MODELS / "terrain.lode"
driven_window.WIDTH, driven_window.HEIGHT = 1120, 630


REST_S = 12  # the picture converges and notices disappear, on a slow machine


def png_of(rows):
    """Encodes rows of pixels, three bytes each."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)) + \
        chunk(b"IEND", b"")


def save(name, window):
    window.picture()
    time.sleep(REST_S)  # until the message that names the picture has disappeared
    (HERE / f"{name}.png").write_bytes(png_of(window.pixels()))


def picks(window):
    for place in ((700, 330), (880, 215)):
        window.click(place)
        time.sleep(2)
    window.move((770, 400))


def walk(window):
    window.move((812, 266))
    for _ in range(2):
        window.key("Tab")
        time.sleep(1)
    window.drag((800, 200), (800, 330), (800, 460))


def errors(window):
    for _ in range(8):
        window.key("v")
    window.move((700, 330))


def main():
    for name, act in (("window", picks), ("window_walk", walk), ("window_errors", errors)):
        with tempfile.TemporaryDirectory() as folder, driven_window.display(folder) as screen, \
                driven_window.Window(screen, folder, MODEL, "--pixels", "1") as window:
            window.key("F1")
            time.sleep(REST_S)
            act(window)
            save(name, window)


if __name__ == "__main__":
    main()
