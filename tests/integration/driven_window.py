"""Drives a window by keys and a pointer that the X server sends, for tests: TEST.py BIN_DIR MODELS_DIR [TEST
...]

Each test has its own Xvfb. xdotool presses keys and moves the pointer; xclip reads the clipboard. The tests
check the results of the window: recorded cameras (P), pictures (F12), copied texts (C), its exit status. Pictures
do not have the panel; screen() reads the window with its panel from the display. """
import contextlib
import ctypes
import json
import math
import os
import pathlib
import shutil
import signal
import socket
import socketserver
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "load"))
from processes import display, eventually, running  # noqa: E402

BIN, MODELS = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
STORE = MODELS / "painted.lode"
WIDTH, HEIGHT = 480, 360
MIDDLE = (WIDTH // 2, HEIGHT // 2)


class WithoutBlobs(socketserver.StreamRequestHandler):
    """A proxy between client and server that drops blobs."""

    def handle(self):
        with socket.create_connection(self.server.behind) as behind, behind.makefile("rb") as said:
            threading.Thread(target=self.ask, args=[behind], daemon=True).start()
            with contextlib.suppress(OSError):
                while header := said.read(12):
                    size, kind = struct.unpack_from("<IB", header)
                    frame = header + said.read(size)
                    if kind != 9:
                        self.wfile.write(frame)

    def ask(self, behind):
        with contextlib.suppress(OSError):
            while asked := self.request.recv(65536):
                behind.sendall(asked)
            behind.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def served_without_blobs():
    """Serves a model but answers no request for blobs."""
    command = [BIN / "lodestreamd", "serve", STORE, "--listen", "127.0.0.1:0"]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server, \
            socketserver.ThreadingTCPServer(("127.0.0.1", 0), WithoutBlobs) as between:
        host, port = json.loads(server.stdout.readline())["listen"].split(":")
        between.behind, between.daemon_threads, between.block_on_close = (host, int(port)), True, False
        threading.Thread(target=between.serve_forever, daemon=True).start()
        yield f"lode://127.0.0.1:{between.server_address[1]}/painted"
        between.shutdown()


class SelectionEvent(ctypes.Structure):
    """XSelectionEvent of Xlib, as large as XEvent."""

    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong),
                ("property", ctypes.c_ulong), ("time", ctypes.c_ulong), ("rest", ctypes.c_ulong * 15)]


class Window:
    """Runs `lodestream view` on a display, with its files in a folder. Leaving the `with` block ends the program.
    Without a target, the window shows the start page."""

    def __init__(self, screen, folder, target, *options, **pipes):
        self.folder, self.pipes = pathlib.Path(folder), pipes
        self.environment = dict(os.environ, DISPLAY=screen, HOME=folder, XDG_CACHE_HOME=folder, LIBGL_ALWAYS_SOFTWARE="1")
        targets = [] if target is None else [target]
        self.command = [BIN / "lodestream", "view", *targets, "--size", f"{WIDTH}x{HEIGHT}", *options]

    def __enter__(self):
        with contextlib.ExitStack() as stack:
            self.process = stack.enter_context(running(self.command, cwd=self.folder, env=self.environment, **self.pipes))
            self.id = self.xdotool("search", "--sync", "--onlyvisible", "--name", "Lodestream").split()[-1]
            self.xdotool("windowfocus", self.id)
            self.move(MIDDLE)
            self.ended = stack.pop_all()
        return self

    def __exit__(self, *_):
        self.ended.close()

    def xdotool(self, *arguments):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True, capture_output=True, text=True,
                              timeout=120)
        return done.stdout

    def key(self, name):
        self.xdotool("key", name)

    def move(self, to):
        self.xdotool("mousemove", "--window", self.id, *to)

    def click(self, at, button=1, times=1):
        self.move(at)
        self.xdotool("click", "--repeat", times, "--delay", 60, button)

    @contextlib.contextmanager
    def one_frame(self):
        """Collects the keys pressed inside the `with` block, and sends them together at its end."""
        self.process.send_signal(signal.SIGSTOP)
        yield
        self.process.send_signal(signal.SIGCONT)

    def drop(self, *files):
        """Drops files on the window: sends the last message of a drag, which has the list of files."""
        uris = "".join(f"{pathlib.Path(file).absolute().as_uri()}\r\n" for file in files).encode()
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype, x11.XInternAtom.restype = ctypes.c_void_p, ctypes.c_ulong
        screen = ctypes.c_void_p(x11.XOpenDisplay(self.environment["DISPLAY"].encode()))
        window = ctypes.c_ulong(int(self.id))
        selection, uri_list = (ctypes.c_ulong(x11.XInternAtom(screen, name, 0)) for name in (b"XdndSelection", b"text/uri-list"))
        x11.XChangeProperty(screen, window, selection, uri_list, 8, 0, uris, len(uris))
        event = SelectionEvent(type=31, requestor=window, selection=selection, target=uri_list, property=selection)
        x11.XSendEvent(screen, window, 0, ctypes.c_long(0), ctypes.byref(event))
        x11.XCloseDisplay(screen)

    def drag(self, start, *ends):
        """Moves the pointer from point to point. The window draws a picture at each point."""
        self.move(start)
        self.xdotool("mousedown", 1)
        for end in ends:
            self.move(end)
            self.picture()
        self.xdotool("mouseup", 1)

    def saved(self, ending, parse):
        """Returns the content of the next saved file once it is complete, and removes the file."""
        def read():
            for file in self.folder.glob(f"lodestream-*.{ending}"):
                with contextlib.suppress(ValueError):
                    content = parse(file.read_bytes())
                    file.unlink()
                    return content
            return None
        return eventually(read)

    def picture(self):
        """Saves a picture of the window when it is nearly at rest, so that all earlier keys have had their
        effect."""
        self.key("F12")
        return self.saved_picture()

    def saved_picture(self):
        def whole(png):
            if not png.endswith(b"IEND\xaeB`\x82"):
                raise ValueError
            return png
        return self.saved("png", whole)

    def screen(self):
        """Returns the rows of the window's pixels on the display, with its panel, once all earlier keys have had
        their effect."""
        self.picture()
        return self.pixels()

    def pixels(self):
        """Returns the rows of the window's pixels on the display as they are now. Needs display(folder)."""
        at = dict(line.split("=") for line in self.xdotool("getwindowgeometry", "--shell", self.id).split())
        left, top, width, height = (int(at[name]) for name in ("X", "Y", "WIDTH", "HEIGHT"))
        dump = (self.folder / "Xvfb_screen0").read_bytes()
        header = struct.unpack(">25I", dump[:100])  # X11/XWDFile.h
        start, row_bytes = header[0] + 12 * header[19], header[12]
        rows = []
        for y in range(top, top + height):
            line = dump[start + y * row_bytes + 4 * left:start + y * row_bytes + 4 * (left + width)]
            row = bytearray(3 * width)
            row[0::3], row[1::3], row[2::3] = line[2::4], line[1::4], line[0::4]
            rows.append(row)
        return rows

    def recorded(self, act):
        """Records the camera during act(). Returns the keys of the recorded path."""
        self.key("p")
        self.picture()
        act()
        self.picture()
        self.key("p")
        return self.saved("json", json.loads)["keys"]

    def hold(self, key):
        """Holds a key until a picture has been drawn."""
        self.xdotool("keydown", key)
        self.picture()
        self.xdotool("keyup", key)

    def copied(self):
        self.key("c")
        self.picture()
        return subprocess.run(["xclip", "-o", "-selection", "clipboard"], env=self.environment, check=True, capture_output=True,
                              text=True, timeout=120).stdout

    def leave_at_once(self, within_s=5):
        """Presses Escape and returns the exit status. The program must end in time; time that it waits for a
        CPU does not count."""
        delay = pathlib.Path(f"/proc/{self.process.pid}/schedstat")

        def waited_s():
            with contextlib.suppress(OSError):
                return int(delay.read_text().split()[1]) * 1e-9
            return 0
        self.key("Escape")
        start, before_s = time.monotonic(), waited_s()
        while self.process.poll() is None:
            assert time.monotonic() - start - max(0, waited_s() - before_s) < within_s, "it has not ended at once"
            time.sleep(0.01)
        return self.process.returncode

    def leave(self):
        """Presses Escape and returns the exit status."""
        self.key("Escape")
        return self.process.wait(timeout=120)


def size_of(png):
    return struct.unpack(">II", png[16:24])


def pixels_of(png):
    """Decodes a PNG. Returns its rows, three bytes per pixel."""
    (width, height), packed, at = size_of(png), b"", 8
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        packed += png[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    lines, row, rows = zlib.decompress(packed), bytearray(3 * width), []
    for number in range(height):  # undo the filters: http://www.w3.org/TR/png, section 9
        kind, *line = lines[number * (3 * width + 1):(number + 1) * (3 * width + 1)]
        above, row = row, bytearray(line)
        for i in range(3 * width if kind else 0):
            left, up, corner = row[i - 3] if i >= 3 else 0, above[i], above[i - 3] if i >= 3 else 0
            paeth = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
        rows.append(row)
    return rows


def lower_half(png):
    """Returns the pixels of the lower half of a picture."""
    return lower_rows(pixels_of(png))


def lower_rows(rows):
    """Returns the pixels of the lower half of rows."""
    return b"".join(rows[len(rows) // 2:])


def direction(key):
    along = [b - a for a, b in zip(key["eye"], key["target"])]
    return [part / math.hypot(*along) for part in along]


def place_of(copied):
    return [float(number) for number in copied.split("\n")[0].split()]


def moved(keys):
    return [b - a for a, b in zip(keys[0]["eye"], keys[-1]["eye"])]


def place_in_picture(camera, point):
    """Projects a point into the picture of a recorded camera with a field of view of 45 degrees."""
    def cross(a, b):
        return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))
    forward = direction(camera)
    right = cross(forward, camera["up"])
    right = [part / math.hypot(*right) for part in right]
    away = [b - a for a, b in zip(camera["eye"], point)]
    scale = HEIGHT / 2 / math.tan(math.radians(22.5)) / dot(away, forward)
    return round(WIDTH / 2 + dot(away, right) * scale), round(HEIGHT / 2 - dot(away, cross(right, forward)) * scale)


def at_rest(window):
    """Returns the rows of a settled picture; None if the picture still changes."""
    one, two = (pixels_of(window.picture()) for _ in range(2))
    return two if one == two else None


class WindowTest(unittest.TestCase):
    @contextlib.contextmanager
    def window(self, target=STORE, *options, is_open=True, **pipes):
        with tempfile.TemporaryDirectory() as folder, display(folder) as screen, \
                Window(screen, folder, target, *options, **pipes) as window:
            if is_open:
                window.picture()  # the first key closes the help of the first start
            yield window


def main():
    """Runs the tests. Exits with status 77 if a program is missing."""
    if missing := [program for program in ("Xvfb", "xdotool", "xclip") if not shutil.which(program)]:
        print(f"skipped: install {', '.join(missing)}")
        sys.exit(77)
    unittest.main()
