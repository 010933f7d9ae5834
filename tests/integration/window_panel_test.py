#!/usr/bin/python3
"""Tests of the window's panel, pictures and settings; see driven_window.py."""
import json
import math
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from driven_window import (BIN, HEIGHT, MODELS, STORE, WIDTH, Window, WindowTest, at_rest, lower_half, lower_rows, main, moved, pixels_of,
                           served_without_blobs, size_of)
from processes import display, eventually

class Opening(WindowTest):
    def test_refuses_a_file_of_another_format_before_it_needs_a_display(self):
        with tempfile.NamedTemporaryFile("w", suffix=".obj") as mesh:
            mesh.write("v 0 0 0\n")
            mesh.flush()
            done = subprocess.run([BIN / "lodestream", "view", mesh.name], env={}, capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is an OBJ", done.stderr)

    def test_prints_one_line_without_a_display(self):
        for _ in range(10):
            done = subprocess.run([BIN / "lodestream", "view", STORE], env={}, capture_output=True, text=True)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn("no window can be opened", done.stderr)


class Shown(WindowTest):
    def test_panel_is_hidden_and_shown_by_a_key(self):
        with self.window() as window:
            window.key("h")
            bare = lower_rows(window.screen())
            window.key("h")
            self.assertFalse(lower_rows(window.screen()) == bare)
            window.key("h")
            self.assertTrue(lower_rows(window.screen()) == bare)

    def test_pictures_have_no_panel_or_settings(self):
        with self.window() as window:
            bare = eventually(lambda: at_rest(window))
            window.key("o")
            self.assertEqual(pixels_of(window.picture()), bare)
            self.assertNotEqual(lower_rows(window.screen()), lower_rows(bare))
            window.key("h")  # hides the scale bar and the axes too
            self.assertEqual([row[:3 * 200] for row in pixels_of(window.picture())], [row[:3 * 200] for row in bare])

    def test_screenshot_has_no_panel(self):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, STORE, "--screenshot", "a.png")
            subprocess.run(window.command, env=window.environment, cwd=folder, check=True, timeout=120)
            rows = pixels_of(pathlib.Path(folder, "a.png").read_bytes())
        sky = [tuple(row[3 * 20:3 * 20 + 3]) for row in rows[30:150]]
        self.assertTrue(all(a[2] >= b[2] - 1 for a, b in zip(sky, sky[1:])), "only the background, which darkens downwards")

    def test_panel_settings_and_help_do_not_overlap(self):
        with self.window() as window:
            window.xdotool("windowsize", "--sync", window.id, 700, 420)
            panel_end = 12 + 280 + 2 * 8 + 2 * 4
            settings_begin = 700 - 12 - 21 * 15
            window.move((600, 400))  # the pointer is on the display too
            bare = eventually(lambda: at_rest(window))

            def differ(begin, end):
                shown = window.screen()
                return any(a[3 * begin:3 * end] != b[3 * begin:3 * end] for a, b in zip(shown[:350], bare))
            window.key("o")
            self.assertFalse(differ(panel_end, settings_begin))
            self.assertTrue(differ(settings_begin, settings_begin + 50))
            self.assertTrue(differ(20, panel_end))

    def test_panel_leaves_the_right_half_and_lower_edge_of_a_window_free(self):
        with self.window() as window:
            for size in ((WIDTH, HEIGHT), (420, 240)):
                window.xdotool("windowsize", "--sync", window.id, *size)
                window.move((20, 20))
                window.picture()
                window.xdotool("key", "--delay", "0", *["v"] * 5)  # the mode "nodes" has the longest legend
                bare = eventually(lambda: at_rest(window))
                shown = window.screen()
                self.assertEqual([row[3 * size[0] // 2:] for row in shown], [row[3 * size[0] // 2:] for row in bare])
                self.assertEqual(shown[-8:], bare[-8:])
                self.assertNotEqual(shown[size[1] // 2:], bare[size[1] // 2:])
                window.xdotool("key", "--delay", "0", *["shift+v"] * 5)

    @unittest.skipUnless(pathlib.Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf").exists(), "needs fonts-dejavu-core")
    def test_names_are_drawn_in_cyrillic_and_greek(self):
        titles = set()
        with tempfile.TemporaryDirectory() as folder:
            for name in ("Жук", "Яма", "\u03a9\u03a3\u0394"):
                shutil.copy(STORE, pathlib.Path(folder, f"{name}.lode"))
                with self.window(pathlib.Path(folder, f"{name}.lode")) as window:
                    titles.add(b"".join(row[3 * 16:3 * 100] for row in window.screen()[20:38]))
        self.assertEqual(len(titles), 3)

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

    def test_picture_is_written_even_if_the_window_closes_at_once(self):
        with self.window() as window:
            window.xdotool("key", "--delay", "0", "F12", "Escape")
            self.assertEqual(window.process.wait(timeout=120), 0)
            self.assertEqual(size_of(window.saved_picture()), (WIDTH, HEIGHT))

    def test_screenshot_fails_if_the_window_closes_before_it_is_taken(self):
        with served_without_blobs() as target, \
                self.window(target, "--screenshot", "a.png", is_open=False, stderr=subprocess.PIPE) as window:
            self.assertEqual(window.leave(), 1)
            with window.process.stderr as said:
                self.assertIn(b"closed before the picture a.png was saved", said.read())

    def test_fills_the_screen_and_returns_by_a_key(self):
        with self.window() as window:
            for size in ((1400, 900), (WIDTH, HEIGHT)):  # of display() and of the window
                window.key("F11")
                eventually(lambda size=size: size_of(window.picture()) == size)

    def test_picture_has_the_window_size_and_survives_unmapping(self):
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


class Settings(WindowTest):
    LEFT = WIDTH - 12 - 21 * 15 + 8  # x at which the letters begin; y of the middle of a row
    ROWS = [12 + 8 + 10 + 25 * row for row in range(8)]

    def test_are_changed_by_the_mouse_without_moving_the_camera(self):
        with self.window() as window:
            window.key("h")
            window.key("v")
            unlit = lower_half(window.picture())
            window.key("shift+v")
            lit = lower_half(window.picture())
            self.assertFalse(unlit == lit)
            window.key("o")
            window.picture()
            keys = window.recorded(lambda: window.click((self.LEFT + 10, self.ROWS[0])))
            self.assertEqual(self.bare(window), unlit)
            keys += window.recorded(lambda: window.click((self.LEFT + 10, self.ROWS[0])))
            self.assertEqual(self.bare(window), lit)
            keys += window.recorded(lambda: window.drag((self.LEFT + 20, self.ROWS[3]), (self.LEFT + 80, self.ROWS[3]),
                                                        (self.LEFT + 130, HEIGHT - 20)))  # set the exposure
            keys += window.recorded(lambda: window.click((self.LEFT + 60, self.ROWS[4]), button=4))
            self.assertFalse(self.bare(window) == lit)
            self.assertEqual({tuple(key["eye"]) for key in keys}, {tuple(keys[0]["eye"])})
            window.move((20, HEIGHT - 20))
            turned = window.recorded(lambda: window.drag((20, HEIGHT - 60), (80, HEIGHT - 60)))
            self.assertGreater(math.hypot(*moved(turned)), 0)

    def test_are_opened_and_closed_within_one_frame(self):
        with self.window() as window:
            window.key("h")
            closed = lower_half(window.picture())
            with window.one_frame():
                for _ in range(2):
                    window.key("o")
            self.assertEqual(lower_half(window.picture()), closed)

    def test_give_more_memory_and_take_it_back(self):
        self.give_memory_and_take_it_back(MODELS / "asteroid2m.lode")

    def test_take_memory_back_from_all_models_of_a_scene(self):
        names = ("one", "other")
        scene = {"models": dict.fromkeys(names, str(MODELS / "asteroid2m.lode")),
                 "instances": [{"model": name, "position": [1.5 * number, 0, 0]} for number, name in enumerate(names)]}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "scene.json")
            file.write_text(json.dumps(scene))
            self.give_memory_and_take_it_back(file)

    def give_memory_and_take_it_back(self, target):
        with self.window(target, "--pixels", "0.25", "--memory-budget", "16MiB") as window:
            window.key("h")
            window.key("o")
            window.picture()

            def at_rest():
                one, two = self.bare(window), self.bare(window)
                return one if one == two else None
            coarse = eventually(at_rest)
            window.click((self.LEFT + 130, self.ROWS[7]))
            window.picture()
            eventually(lambda: self.bare(window) != coarse)
            fine = eventually(at_rest)
            window.click((self.LEFT + 5, self.ROWS[7]))
            window.picture()
            eventually(lambda: self.bare(window) != fine)

    @staticmethod
    def bare(window):
        window.key("o")
        picture = lower_half(window.picture())
        window.key("o")
        window.picture()
        return picture


class Scrolling(WindowTest):
    def test_of_a_tall_panel_does_not_move_the_camera(self):
        with self.window() as window:
            over = (60, HEIGHT // 2)
            name = self.name_in(window)
            keys = window.recorded(lambda: window.click(over, button=5, times=4))
            self.assertFalse(self.name_in(window) == name)
            self.assertEqual({tuple(key["eye"]) for key in keys}, {tuple(keys[0]["eye"])})
            window.click(over, button=4, times=4)
            self.assertTrue(self.name_in(window) == name)

    @staticmethod
    def name_in(window):
        """Returns the pixels at the top of the panel, where the model's name is."""
        return [row[3 * 16:3 * 80] for row in window.screen()[16:34]]


if __name__ == "__main__":
    main()
