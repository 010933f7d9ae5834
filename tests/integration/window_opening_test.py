#!/usr/bin/python3
"""Tests of the window if its target cannot be opened, lacks a model or loses its server; see
driven_window.py."""
import contextlib
import json
import pathlib
import re
import socket
import subprocess
import tempfile
import urllib.request

from driven_window import BIN, HEIGHT, MIDDLE, STORE, WIDTH, Window, WindowTest, lower_half, main, place_of, size_of
from processes import display, eventually, free_port, running


def reds_of(rows):
    """Counts the pixels that have the colour of errors."""
    pixels = b"".join(rows)
    return sum(r > 200 and g < 150 and b < 140 for r, g, b in zip(pixels[::3], pixels[1::3], pixels[2::3]))


class Failure(WindowTest):
    """If the target cannot be opened, the window stays open and shows the reason. stderr has the reason at
    once."""

    def test_stays_in_the_window_and_sets_the_exit_status(self):
        nobody = f"lode://127.0.0.1:{free_port()}/painted"
        with running([BIN / "lodestreamd", "serve", STORE, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE,
                     stderr=subprocess.DEVNULL) as server, tempfile.TemporaryDirectory() as folder:
            listen = json.loads(server.stdout.readline())["listen"]
            damaged, no_ply = pathlib.Path(folder, "damaged.lode"), pathlib.Path(folder, "broken.ply")
            damaged.write_bytes(STORE.read_bytes()[:1000])
            no_ply.write_text("ply\nnonsense\n")
            for target, said, key in ((nobody, "cannot connect", "Escape"), (f"lode://{listen}/nomodel", "nomodel", "q"),
                                      (damaged, "damaged.lode", "Escape"), (no_ply, "broken.ply", "q")):
                with self.subTest(target), self.window(target, is_open=False, stderr=subprocess.PIPE) as window:
                    with window.process.stderr as stderr:
                        lines = (line.decode() for line in stderr)
                        # Libraries may print further lines.
                        self.assertIn(said, next(line for line in lines if line.startswith("lodestream")))
                        self.assertEqual(size_of(window.picture()), (WIDTH, HEIGHT))
                        self.assertGreater(reds_of(window.screen()), 100)
                        window.key(key)
                        self.assertEqual(window.process.wait(timeout=120), 1)
                        self.assertEqual(list(lines), [])

    def test_ends_screenshots_and_flights_at_once(self):
        for options in (["--screenshot", "a.png"], ["--laps", "1"]):
            with self.subTest(options), tempfile.TemporaryDirectory() as folder, display() as screen:
                window = Window(screen, folder, f"lode://127.0.0.1:{free_port()}/painted", *options)
                ended = subprocess.run(window.command, env=window.environment, cwd=folder, capture_output=True, timeout=120)
                self.assertEqual(ended.returncode, 1)
                self.assertIn(b"cannot connect", ended.stderr)


class IncompleteScene(WindowTest):
    """The window shows a scene without its missing model."""

    @contextlib.contextmanager
    def scene(self, **others):
        """Makes a scene with an available model on the left. The other models, on the right, may be
        missing."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "scene.json")
            instances = [{"model": name, "position": [4 * number, 0, 0]} for number, name in enumerate(["here", *others])]
            file.write_text(json.dumps({"models": {"here": str(STORE), **others}, "instances": instances}))
            yield file

    def test_names_missing_models_and_shows_the_rest(self):
        with self.scene(gone="gone.ply", away=f"lode://127.0.0.1:{free_port()}/painted") as file, \
                self.window(file, stderr=subprocess.PIPE) as window, window.process.stderr as stderr:
            for said in ('scene.json: "gone" is missing: ', 'scene.json: "away" is missing: cannot connect'):
                self.assertIn(said, next(line for line in map(bytes.decode, stderr) if line.startswith("lodestream")))
            eventually(lambda: self.picked(window, MIDDLE))
            self.assertGreater(reds_of(window.screen()), 100)
            window.key("Escape")  # ends the measurement
            window.picture()
            self.assertEqual(window.leave(), 0)

    def test_shows_a_model_once_its_server_starts(self):
        port = free_port()
        with self.scene(away=f"lode://127.0.0.1:{port}/painted") as file, self.window(file, "--cache", "off") as window:
            self.assertLess(place_of(self.picked(window, MIDDLE))[0], 2)
            with running([BIN / "lodestreamd", "serve", STORE, "--listen", f"127.0.0.1:{port}"], stdout=subprocess.DEVNULL,
                         stderr=subprocess.DEVNULL):
                eventually(lambda: self.at_right(window) > 2)

    def test_connects_to_all_its_servers_at_once(self):
        """The window connects to all unresponsive servers at the same time, so it waits only once."""
        with socket.create_server(("127.0.0.1", 0)) as first, socket.create_server(("127.0.0.1", 0)) as second:
            silent = {f"silent{number}": f"lode://127.0.0.1:{server.getsockname()[1]}/painted"
                      for number, server in enumerate((first, second))}
            with self.scene(**silent) as file, self.window(file, "--timeout", "3600", is_open=False):
                first.settimeout(60)
                second.settimeout(15)  # shorter than the timeout of a connection
                with first.accept()[0], second.accept()[0]:
                    pass

    def test_is_refused_for_a_screenshot(self):
        with self.scene(gone="gone.ply") as file, tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, file, "--screenshot", "a.png")
            ended = subprocess.run(window.command, env=window.environment, cwd=folder, capture_output=True, timeout=120)
            self.assertEqual(ended.returncode, 1)
            self.assertIn(b"gone.ply: no such file", ended.stderr)

    @staticmethod
    def picked(window, at):
        window.click(at)
        return window.copied()

    def at_right(self, window):
        """Resets the camera, so that it frames all models. Returns the x coordinate of a point picked on the
        right."""
        window.key("r")
        window.picture()
        return place_of(self.picked(window, (WIDTH * 3 // 4, MIDDLE[1])))[0]


class Dropped(WindowTest):
    """Dropping a file on the window replaces the model."""

    def test_models_and_scenes_open_one_after_another(self):
        with tempfile.TemporaryDirectory() as folder, self.window() as window:
            ply, scene, store = (pathlib.Path(folder, name) for name in ("a b.ply", "two.json", "c.lode"))
            subprocess.run([BIN / "lodestreamd", "sample", "gyroid", "--triangles", "4000", "-o", ply], check=True,
                           capture_output=True)
            scene.write_text(json.dumps({"models": {"a": str(STORE)}, "instances": [{"model": "a"}]}))
            store.symlink_to(STORE)
            window.key("h")  # the panel would differ
            window.key("r")
            before = lower_half(window.picture())
            for file, title in ((ply, "a b"), (scene, "two.json"), (store, "c")):
                window.drop(file, STORE)
                eventually(lambda title=title: self.title(window) == f"{title} - Lodestream")  # once it is open
            eventually(lambda: lower_half(window.picture()) == before)
            self.assertEqual(window.leave(), 0)

    def test_files_that_are_no_model_leave_the_model(self):
        with tempfile.TemporaryDirectory() as folder, self.window() as window:
            obj = pathlib.Path(folder, "a.obj")
            obj.write_text("v 0 0 0\n")
            title = self.title(window)
            for file in (obj, folder, obj.with_name("gone.ply")):
                window.drop(file)
                window.picture()
                self.assertEqual(self.title(window), title)
                window.click(MIDDLE)
                self.assertIn("LOD", window.copied())
            window.key("Escape")  # ends the measurement
            window.picture()
            self.assertEqual(window.leave(), 0)

    def test_file_replaces_a_target_that_cannot_be_opened(self):
        with self.window(f"lode://127.0.0.1:{free_port()}/painted", is_open=False, stderr=subprocess.DEVNULL) as window:
            window.drop(STORE)
            eventually(lambda: self.title(window) == "painted - Lodestream")
            self.assertEqual(window.leave(), 0)

    @staticmethod
    def title(window):
        return window.xdotool("getwindowname", window.id).strip()


class Connection(WindowTest):
    def test_attempt_without_an_answer_does_not_delay_closing(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            target = f"lode://127.0.0.1:{silent.getsockname()[1]}/painted"
            with self.window(target, "--timeout", "3600", is_open=False) as window:
                with silent.accept()[0]:
                    window.picture()  # the key also closes the help of the first start
                    self.assertEqual(window.leave_at_once(), 0)

    def test_is_restored_once_the_server_is_back(self):
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
    main()
