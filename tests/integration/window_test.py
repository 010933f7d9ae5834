#!/usr/bin/python3
"""The window under keys and a pointer that the X server sends: window_test.py BIN_DIR MODELS_DIR [TEST ...]

Each test has an Xvfb of its own; xdotool presses and moves, xclip reads the clipboard. What the window did is told by what it
leaves: recorded cameras (P), pictures (F12), texts that are copied (C), its exit status. Ends with 77 where one of these programs
is missing.
"""
import contextlib
import json
import math
import os
import pathlib
import re
import shutil
import socket
import socketserver
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import urllib.request
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "load"))
from processes import eventually, free_port, running  # noqa: E402

BIN, MODELS = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
STORE = MODELS / "painted.lode"
WIDTH, HEIGHT = 480, 360
MIDDLE = (WIDTH // 2, HEIGHT // 2)


@contextlib.contextmanager
def display():
    """The name of a screen that nobody sees."""
    reader, writer = os.pipe()
    with running(["Xvfb", "-displayfd", writer, "-screen", "0", "1024x768x24", "-nolisten", "tcp"], pass_fds=[writer],
                 stderr=subprocess.DEVNULL):
        os.close(writer)
        with open(reader) as said:
            yield f":{said.readline().strip()}"


class WithoutBlobs(socketserver.StreamRequestHandler):
    """Between a client and a server: blobs get lost."""

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
    """A model whose server answers, but for blobs."""
    command = [BIN / "lodestreamd", "serve", STORE, "--listen", "127.0.0.1:0"]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server, \
            socketserver.ThreadingTCPServer(("127.0.0.1", 0), WithoutBlobs) as between:
        host, port = json.loads(server.stdout.readline())["listen"].split(":")
        between.behind, between.daemon_threads, between.block_on_close = (host, int(port)), True, False
        threading.Thread(target=between.serve_forever, daemon=True).start()
        yield f"lode://127.0.0.1:{between.server_address[1]}/painted"
        between.shutdown()


class Window:
    """`lodestream view` on a display, with its files in a folder; ended with the `with`."""

    def __init__(self, screen, folder, target, *options, **pipes):
        self.folder, self.pipes = pathlib.Path(folder), pipes
        self.environment = dict(os.environ, DISPLAY=screen, HOME=folder, XDG_CACHE_HOME=folder, LIBGL_ALWAYS_SOFTWARE="1")
        self.command = [BIN / "lodestream", "view", target, "--size", f"{WIDTH}x{HEIGHT}", *options]

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

    def drag(self, start, *ends):
        """From place to place; at each a picture is drawn."""
        self.move(start)
        self.xdotool("mousedown", 1)
        for end in ends:
            self.move(end)
            self.picture()
        self.xdotool("mouseup", 1)

    def saved(self, ending, parse):
        """What is in the file that it saves, once that is whole; the file is gone then."""
        def read():
            for file in self.folder.glob(f"lodestream-*.{ending}"):
                with contextlib.suppress(ValueError):
                    content = parse(file.read_bytes())
                    file.unlink()
                    return content
            return None
        return eventually(read)

    def picture(self):
        """Of the window at rest, or nearly so: when it is there, all that was pressed before has been done."""
        self.key("F12")
        return self.saved_picture()

    def saved_picture(self):
        def whole(png):
            if not png.endswith(b"IEND\xaeB`\x82"):
                raise ValueError
            return png
        return self.saved("png", whole)

    def recorded(self, act):
        """The camera's keys while something is done."""
        self.key("p")
        self.picture()
        act()
        self.picture()
        self.key("p")
        return self.saved("json", json.loads)["keys"]

    def hold(self, key):
        """Until a picture has been drawn with it."""
        self.xdotool("keydown", key)
        self.picture()
        self.xdotool("keyup", key)

    def copied(self):
        self.key("c")
        self.picture()
        return subprocess.run(["xclip", "-o", "-selection", "clipboard"], env=self.environment, check=True, capture_output=True,
                              text=True, timeout=120).stdout

    def leave(self):
        """Its exit status after Escape."""
        self.key("Escape")
        return self.process.wait(timeout=120)


def size_of(png):
    return struct.unpack(">II", png[16:24])


def lower_half(png):
    """Its pixels: above stands what the window says, of the last picture that was saved too."""
    (width, height), packed, at = size_of(png), b"", 8
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        packed += png[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    lines, row, rows = zlib.decompress(packed), bytearray(3 * width), []
    for number in range(height):  # http://www.w3.org/TR/png, 9: what each filter adds
        kind, *line = lines[number * (3 * width + 1):(number + 1) * (3 * width + 1)]
        above, row = row, bytearray(line)
        for i in range(3 * width if kind else 0):
            left, up, corner = row[i - 3] if i >= 3 else 0, above[i], above[i - 3] if i >= 3 else 0
            paeth = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
        rows.append(row)
    return b"".join(rows[height // 2:])


def direction(key):
    along = [b - a for a, b in zip(key["eye"], key["target"])]
    return [part / math.hypot(*along) for part in along]


def place_of(copied):
    return [float(number) for number in copied.split("\n")[0].split()]


def moved(keys):
    return [b - a for a, b in zip(keys[0]["eye"], keys[-1]["eye"])]


class WindowTest(unittest.TestCase):
    @contextlib.contextmanager
    def window(self, target=STORE, *options, is_open=True, **pipes):
        with tempfile.TemporaryDirectory() as folder, display() as screen, \
                Window(screen, folder, target, *options, **pipes) as window:
            if is_open:
                window.picture()  # with the first key the help of the first start goes
            yield window


class Camera(WindowTest):
    def test_orbits_about_what_is_under_the_pointer(self):
        with self.window() as window:
            at = (WIDTH * 2 // 5, HEIGHT * 2 // 5)
            window.click(at)
            pivot = place_of(window.copied())
            keys = window.recorded(lambda: window.drag(at, (at[0] + 20, at[1]), (at[0] + 120, at[1])))
            reach = [math.dist(key["eye"], pivot) for key in keys]
            self.assertGreater(math.dist(keys[0]["eye"], keys[-1]["eye"]), 0.1 * reach[0])
            self.assertLess(max(reach) - min(reach), 0.001 * reach[0])

    def test_comes_nearer_by_the_wheel_and_by_a_double_click(self):
        with self.window() as window:
            for act in (lambda: window.click(MIDDLE, button=4, times=3), lambda: window.click(MIDDLE, times=2)):
                keys = window.recorded(act)
                self.assertGreater(sum(a * b for a, b in zip(moved(keys), direction(keys[-1]))),
                                   0.1 * math.dist(keys[0]["eye"], keys[0]["target"]))

    def test_flies_where_it_looks(self):
        with self.window() as window:
            window.key("Tab")
            keys = window.recorded(lambda: window.hold("w"))
            self.assertLess(math.dist(direction(keys[0]), direction(keys[-1])), 1e-6)
            self.assertGreater(sum(a * b for a, b in zip(moved(keys), direction(keys[0]))), 0.999 * math.hypot(*moved(keys)))
            self.assertGreater(math.hypot(*moved(keys)), 0)

    def test_goes_back_to_the_first_view_and_to_bookmarks(self):
        with self.window() as window:
            window.key("ctrl+1")
            start = window.recorded(lambda: window.drag(MIDDLE, (MIDDLE[0] + 120, MIDDLE[1] + 40)))[0]
            for back in ("r", "1"):
                window.drag(MIDDLE, (MIDDLE[0] + 90, MIDDLE[1] + 60))
                window.picture()
                end = window.recorded(lambda: window.key(back))[-1]
                self.assertLess(math.dist(start["eye"], end["eye"]), 1e-6 * math.dist(start["eye"], start["target"]), back)


class Walk(WindowTest):
    def test_keeps_the_eye_above_the_ground(self):
        with tempfile.TemporaryDirectory() as folder:
            ply, store = (pathlib.Path(folder, f"terrain.{ending}") for ending in ("ply", "lode"))
            subprocess.run([BIN / "lodestreamd", "sample", "terrain", "--triangles", "50000", "--seed", "2", "-o", ply], check=True,
                           capture_output=True)
            subprocess.run([BIN / "lodestreamd", "build", ply, "-o", store, "--quiet"], check=True, capture_output=True)
            with self.window(store) as window:
                window.key("Tab")
                window.picture()
                window.move((MIDDLE[0], HEIGHT * 2 // 3))
                window.key("Tab")
                window.picture()
                eyes = [key["eye"] for key in window.recorded(lambda: window.hold("w"))]
            heights = [eye[2] - self.ground_of(ply, eye) for eye in eyes]
            self.assertGreater(math.dist(eyes[0][:2], eyes[-1][:2]), 0)
            self.assertGreater(min(heights), 0)
            self.assertLess(max(heights), 0.1)  # of a model that is two wide

    def test_begins_on_the_ground_of_a_scene_where_the_pointer_is_and_picks_it(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "scene")
            subprocess.run([BIN / "lodestreamd", "sample", "scene", "--triangles", "3000", "-o", scene], check=True,
                           capture_output=True)
            with self.window(scene / "scene.json") as window:
                beside = (WIDTH // 2, HEIGHT - 20)  # in front of all models
                window.click(beside)
                picked = window.copied()
                self.assertIn("\nthe ground\n", picked)
                window.move(beside)
                for _ in range(2):
                    window.key("Tab")
                    window.picture()
                last = window.recorded(lambda: window.hold("a"))[-1]
        self.assertLess(math.dist(last["eye"][:2], place_of(picked)[:2]), 4)  # it has gone aside meanwhile
        self.assertGreater(last["eye"][2], 0)
        self.assertLess(last["eye"][2], 0.5)
        self.assertAlmostEqual(direction(last)[2], 0, delta=0.01)

    @staticmethod
    def ground_of(ply, eye):
        """The height of the model's nearest vertex, seen from above."""
        head, body = ply.read_bytes().split(b"end_header\n", 1)
        vertices = struct.iter_unpack("<fff", body[:12 * int(re.search(rb"element vertex (\d+)", head).group(1))])
        return min(vertices, key=lambda vertex: math.dist(vertex[:2], eye[:2]))[2]


class Picks(WindowTest):
    def test_are_copied_with_their_place_node_and_distance(self):
        with self.window() as window:
            window.click(MIDDLE)
            one = window.copied()
            self.assertRegex(one, r"^-?[\d.]+ -?[\d.]+ -?[\d.]+\nnode root[/\d]*, rung \d+, error [\d.]+ px\ncolour #[\da-f]{6}\n$")
            window.click((MIDDLE[0] + 40, MIDDLE[1] + 20))
            two = window.copied()
            distance = float(re.search(r"^distance ([\d.]+)$", two, re.M).group(1))
            self.assertAlmostEqual(distance, math.dist(place_of(one), place_of(two)), delta=0.01 * distance)
            self.assertGreater(distance, 0)


class Flight(WindowTest):
    def test_flies_the_path_so_often_says_what_frames_took_and_ends(self):
        path = {"fov_y_deg": 45, "keys": [{"t": t, "eye": [8 - t, 0, 3], "target": [0, 0, 0], "up": [0, 0, 1]} for t in (0, 1)]}
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            camera = pathlib.Path(folder, "path.json")
            camera.write_text(json.dumps(path))
            window = Window(screen, folder, STORE, "--camera", camera, "--laps", "2", "--json")
            flown = json.loads(subprocess.run(window.command, env=window.environment, check=True, capture_output=True, timeout=120).stdout)
        self.assertEqual(len(flown["laps"]), 2)
        self.assertEqual(len(flown["frames"]), sum(lap["frames"] for lap in flown["laps"]))
        for lap in flown["laps"]:
            self.assertGreater(lap["frames"], 1)
            self.assertGreater(lap["triangles"]["p50"], 0)
            self.assertLessEqual(lap["upload_ms"]["max"], lap["work_ms"]["max"])
        times = [(frame["lap"], frame["t"]) for frame in flown["frames"]]
        self.assertEqual(times, sorted(times))

    def test_keeps_the_threshold_that_was_asked_for(self):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, STORE, "--pixels", "3", "--laps", "1", "--json")
            flown = json.loads(subprocess.run(window.command, env=window.environment, check=True, capture_output=True, timeout=120).stdout)
        self.assertEqual({frame["threshold_px"] for frame in flown["frames"]}, {3})

    def test_that_is_cut_short_is_told_as_far_as_it_came_and_fails(self):
        with self.window(STORE, "--laps", "1000", "--json", is_open=False, stdout=subprocess.PIPE) as window:
            eventually(lambda: len(window.recorded(lambda: None)) > 1)  # the camera moves by itself
            self.assertEqual(window.leave(), 1)
            with window.process.stdout as said:
                flown = json.load(said)
        self.assertTrue(flown["interrupted"])
        self.assertGreater(len(flown["frames"]), 1)

    def test_is_not_hidden_by_the_help_of_the_first_start(self):
        with self.window(STORE, "--laps", "1000", is_open=False) as window:
            window.leave()  # a key: with it the help would go, which the cache would remember
            self.assertEqual(list(window.folder.rglob("help-seen")), [])

    def test_that_has_not_begun_fails(self):
        with served_without_blobs() as target, self.window(target, "--laps", "1", is_open=False) as window:
            self.assertEqual(window.leave(), 1)

    def test_fails_where_the_time_ends_before_the_first_picture(self):
        with served_without_blobs() as target:
            self.refused(target, "--cache", "off", "--timeout", "3")

    def test_fails_where_the_cache_has_no_first_picture(self):
        with served_without_blobs() as target, tempfile.TemporaryDirectory() as cache:
            self.refused(target, "--cache", cache, "--timeout", "3")  # it has the model's summary now
            self.refused(target, "--cache", cache, "--offline")

    def refused(self, target, *options):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, target, "--laps", "1", *options)
            ended = subprocess.run(window.command, env=window.environment, capture_output=True, text=True, timeout=120)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("no first picture", ended.stderr)


class Minimized(WindowTest):
    def test_window_ends_a_flight_with_the_time(self):
        self.refused("--laps", "1")

    def test_window_ends_with_the_time_that_its_picture_has(self):
        self.refused("--screenshot", "a.png")

    def refused(self, *options):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, STORE, "--timeout", "1", *options)
            ended = subprocess.run(window.command, env=dict(window.environment, LD_PRELOAD=BIN / "libminimized_window.so"),
                                   cwd=folder, capture_output=True, text=True, timeout=30)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("its window is minimized", ended.stderr)


class Shown(WindowTest):
    def test_panel_comes_and_goes(self):
        with self.window() as window:
            window.key("h")
            bare = lower_half(window.picture())
            window.key("h")
            self.assertFalse(lower_half(window.picture()) == bare)
            window.key("h")
            self.assertTrue(lower_half(window.picture()) == bare)

    def test_views_differ(self):
        with self.window() as window:
            window.key("h")
            pictures = [lower_half(window.picture())]
            window.key("f")
            self.assertFalse(lower_half(window.picture()) == pictures[0])
            window.key("f")
            self.assertTrue(lower_half(window.picture()) == pictures[0])
            for _ in range(4):
                window.key("v")
                pictures.append(lower_half(window.picture()))
            self.assertEqual(len(set(pictures)), len(pictures))

    def test_picture_is_written_though_the_window_is_left_at_once(self):
        with self.window() as window:
            window.xdotool("key", "--delay", "0", "F12", "Escape")
            self.assertEqual(window.process.wait(timeout=120), 0)
            self.assertEqual(size_of(window.saved_picture()), (WIDTH, HEIGHT))

    def test_picture_that_was_asked_for_and_is_not_there_when_the_window_is_closed_is_an_error(self):
        with served_without_blobs() as target, \
                self.window(target, "--screenshot", "a.png", is_open=False, stderr=subprocess.PIPE) as window:
            self.assertEqual(window.leave(), 1)
            with window.process.stderr as said:
                self.assertIn(b"closed before the picture a.png was there", said.read())

    def test_picture_is_as_large_as_the_window_and_survives_that_it_is_hidden(self):
        with self.window() as window:
            self.assertEqual(size_of(window.picture()), (WIDTH, HEIGHT))
            window.xdotool("windowsize", "--sync", window.id, 400, 500)
            self.assertEqual(size_of(window.picture()), (400, 500))
            window.key("h")
            before = lower_half(window.picture())
            window.xdotool("windowunmap", "--sync", window.id)
            window.xdotool("windowmap", "--sync", window.id)
            window.xdotool("windowfocus", window.id)
            self.assertTrue(lower_half(window.picture()) == before)


class Connection(WindowTest):
    def test_that_nobody_answers_does_not_keep_the_window(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            target = f"lode://127.0.0.1:{silent.getsockname()[1]}/painted"
            with self.window(target, "--timeout", "3600", is_open=False) as window:
                with silent.accept()[0]:
                    window.picture()  # with its key the help of the first start goes
                    self.assertEqual(window.leave(), 0)

    def test_is_made_anew_when_the_server_is_back(self):
        ports = free_port(), free_port()
        command = [BIN / "lodestreamd", "serve", STORE, "--listen", f"127.0.0.1:{ports[0]}", "--metrics", f"127.0.0.1:{ports[1]}"]

        def blobs_sent():
            with contextlib.suppress(OSError), urllib.request.urlopen(f"http://127.0.0.1:{ports[1]}/metrics", timeout=10) as answer:
                return sum(map(float, re.findall(r"^lodestream_model_blobs_sent_total\S* (\S+)$", answer.read().decode(), re.M)))

        with contextlib.ExitStack() as servers:
            first = servers.enter_context(running(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            eventually(lambda: blobs_sent() is not None)
            window = servers.enter_context(self.window(f"lode://127.0.0.1:{ports[0]}/painted", "--cache", "off"))
            self.assertGreater(blobs_sent(), 0)
            first.kill()
            first.wait()
            window.key("h")
            alone = lower_half(window.picture())
            servers.enter_context(running(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            eventually(lambda: blobs_sent() is not None)
            window.click(MIDDLE, button=4, times=8)
            eventually(blobs_sent)
            self.assertFalse(lower_half(window.picture()) == alone)
            self.assertEqual(window.leave(), 0)


if __name__ == "__main__":
    if missing := [program for program in ("Xvfb", "xdotool", "xclip") if not shutil.which(program)]:
        print(f"skipped: install {', '.join(missing)}")
        sys.exit(77)
    unittest.main()
