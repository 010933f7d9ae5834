#!/usr/bin/python3
"""Tests of the window under keys and mouse (cameras, picks, settings); see driven_window.py."""
import contextlib
import json
import math
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import unittest

from driven_window import (BIN, HEIGHT, MIDDLE, MODELS, STORE, WIDTH, Window, WindowTest, direction, lower_half, lower_rows, main, moved, place_of,
                           pixels_of, served_without_blobs, size_of)
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


class Camera(WindowTest):
    def test_orbits_about_the_point_under_the_pointer(self):
        with self.window() as window:
            at = (WIDTH * 2 // 5, HEIGHT * 2 // 5)
            window.click(at)
            pivot = place_of(window.copied())
            keys = window.recorded(lambda: window.drag(at, (at[0] + 20, at[1]), (at[0] + 120, at[1])))
            reach = [math.dist(key["eye"], pivot) for key in keys]
            self.assertGreater(math.dist(keys[0]["eye"], keys[-1]["eye"]), 0.1 * reach[0])
            self.assertLess(max(reach) - min(reach), 0.001 * reach[0])

    def test_approaches_by_wheel_and_by_double_click(self):
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

    def test_returns_to_the_first_view_and_to_bookmarks(self):
        with self.window() as window:
            window.key("ctrl+1")
            start = window.recorded(lambda: window.drag(MIDDLE, (MIDDLE[0] + 120, MIDDLE[1] + 40)))[0]
            for back in ("r", "1"):
                window.drag(MIDDLE, (MIDDLE[0] + 90, MIDDLE[1] + 60))
                window.picture()
                end = window.recorded(lambda: window.key(back))[-1]
                self.assertLess(math.dist(start["eye"], end["eye"]), 1e-6 * math.dist(start["eye"], start["target"]), back)


class Views(WindowTest):
    def test_show_the_sides_of_the_model_by_keys(self):
        with self.window() as window:
            seen = {name: direction(window.recorded(lambda name=name: window.key(f"alt+{number}"))[-1])
                    for number, name in enumerate(("front", "back", "left", "right", "top", "bottom"), 1)}
            for one, other in (("front", "back"), ("left", "right"), ("top", "bottom")):
                self.assertLess(math.dist(seen[one], [-part for part in seen[other]]), 1e-6)
            self.assertAlmostEqual(sum(a * b for a, b in zip(seen["front"], seen["left"])), 0, places=6)
            self.assertLess(math.dist(seen["top"], (0, -1, 0)), 1e-6)  # y is up

    def test_have_parallel_projection_and_perspective_by_a_key(self):
        with self.window() as window:
            fields = []
            for _ in range(3):
                window.key("p")
                window.picture()
                window.key("p")
                fields.append(window.saved("json", json.loads)["fov_y_deg"])
                window.key("n")
            for field, wanted in zip(fields, (45, 0.1, 45)):
                self.assertAlmostEqual(field, wanted, places=6)

    def test_keep_the_up_axis_of_a_model(self):
        with tempfile.TemporaryDirectory() as folder, display(folder) as screen:
            with Window(screen, folder, STORE) as window:
                window.picture()
                window.key("u")
                turned = window.recorded(lambda: None)[0]
            with Window(screen, folder, STORE) as window:
                window.picture()
                kept = window.recorded(lambda: None)[0]
            with Window(screen, folder, STORE, "--up", "y") as window:
                window.picture()
                wanted = window.recorded(lambda: None)[0]
        self.assertEqual(kept["up"], turned["up"])
        self.assertLess(math.dist(kept["eye"], turned["eye"]), 1e-6)
        self.assertEqual(wanted["up"], [0, 1, 0])

    def test_have_a_light_that_turns_without_the_camera(self):
        with self.window() as window:
            before = lower_half(window.picture())

            def turn():
                window.xdotool("keydown", "l")
                window.drag(MIDDLE, (MIDDLE[0] + 120, MIDDLE[1] + 60))
                window.xdotool("keyup", "l")
            keys = window.recorded(turn)
            self.assertEqual({tuple(key["eye"]) for key in keys}, {tuple(keys[0]["eye"])})
            self.assertNotEqual(lower_half(window.picture()), before)
            window.key("r")
            self.assertEqual(lower_half(window.picture()), before)


class Sections(WindowTest):
    def test_cut_the_model_open_and_move_by_key_and_drag(self):
        with self.window() as window:
            pictures = [lower_half(window.picture())]
            window.key("x")
            pictures.append(lower_half(window.picture()))
            window.key("shift+x")
            pictures.append(lower_half(window.picture()))

            def move():
                window.xdotool("keydown", "x")
                window.drag(MIDDLE, (MIDDLE[0] + 60, MIDDLE[1]))
                window.xdotool("keyup", "x")
            keys = window.recorded(move)
            self.assertEqual({tuple(key["eye"]) for key in keys}, {tuple(keys[0]["eye"])})
            pictures.append(lower_half(window.picture()))
            self.assertEqual(len(set(pictures)), 4)
            for _ in range(3):  # past y and z
                window.key("x")
                window.picture()
            window.key("r")  # the press has moved the orbited point, and so the scale bar
            self.assertEqual(lower_half(window.picture()), pictures[0])


class HiddenModels(WindowTest):
    def test_leave_the_picture_and_the_picks_until_all_are_shown(self):
        names = ("one", "other")
        with tempfile.TemporaryDirectory() as folder:
            for name in names:
                shutil.copy(STORE, pathlib.Path(folder, f"{name}.lode"))
            scene = {"models": {name: f"{name}.lode" for name in names},
                     "instances": [{"model": name, "position": [4 * number, 0, 0]} for number, name in enumerate(names)]}
            file = pathlib.Path(folder, "scene.json")
            file.write_text(json.dumps(scene))
            with self.window(file) as window:
                window.key("h")
                camera = window.recorded(lambda: None)[0]
                places = {name: place_in_picture(camera, (4 * number, 0, 0)) for number, name in enumerate(names)}
                for name in names:
                    self.assertEqual(self.picked(window, places[name]), name)
                both = eventually(lambda: at_rest(window))
                window.move(places["one"])
                window.key("z")
                self.assertNotEqual(eventually(lambda: at_rest(window)), both)
                self.assertIsNone(self.picked(window, places["one"]))
                window.key("z")  # beside the models
                self.assertEqual(self.picked(window, places["one"]), "one")
                window.move(places["other"])
                window.key("shift+z")
                window.picture()
                self.assertIsNone(self.picked(window, places["one"]))
                self.assertEqual(self.picked(window, places["other"]), "other")

    @staticmethod
    def picked(window, at):
        """Returns the name of the model at a place; None beside the models."""
        window.click(at)
        window.picture()
        subprocess.run(["xclip", "-selection", "clipboard"], env=window.environment, check=True, input=b"", timeout=120)
        found = re.search(r"^model (.*)$", window.copied(), re.M)
        window.click((2, 2))  # beside the models, which ends the measurement
        window.picture()
        return found and found.group(1)


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
            self.assertLess(max(heights), 0.1)  # the model has a width of 2

    def test_begins_at_the_pointer_on_the_ground_of_a_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "scene")
            subprocess.run([BIN / "lodestreamd", "sample", "scene", "--triangles", "3000", "-o", scene], check=True,
                           capture_output=True)
            with self.window(scene / "scene.json") as window:
                beside = (WIDTH // 2, HEIGHT - 20) # a point in front of all models
                window.click(beside)
                picked = window.copied()
                self.assertIn("\nthe ground\n", picked)
                window.move(beside)
                for _ in range(2):
                    window.key("Tab")
                    window.picture()
                keys = window.recorded(lambda: window.hold("a"))
        self.assertLess(min(math.dist(key["eye"][:2], place_of(picked)[:2]) for key in keys), 4)  # later the
                                                                                                  # camera
                                                                                                  # moves
                                                                                                  # aside
        last = keys[-1]
        self.assertGreater(last["eye"][2], 0)
        self.assertLess(last["eye"][2], 0.5)
        self.assertAlmostEqual(direction(last)[2], 0, delta=0.01)

    @staticmethod
    def ground_of(ply, eye):
        """Returns the height of the model's vertex nearest to the eye, seen from above."""
        head, body = ply.read_bytes().split(b"end_header\n", 1)
        vertices = struct.iter_unpack("<fff", body[:12 * int(re.search(rb"element vertex (\d+)", head).group(1))])
        return min(vertices, key=lambda vertex: math.dist(vertex[:2], eye[:2]))[2]


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


class Picks(WindowTest):
    def test_are_copied_with_their_place_node_and_distance(self):
        with self.window() as window:
            window.click(MIDDLE)
            one = window.copied()
            self.assertRegex(one, r"^-?[\d.]+ -?[\d.]+ -?[\d.]+\nnode root[/\d]*, LOD \d+, error [\d.]+ px\ncolour #[\da-f]{6}\n$")
            window.click((MIDDLE[0] + 40, MIDDLE[1] + 20))
            two = window.copied()
            distance = float(re.search(r"^distance ([\d.]+) ± [\d.]+$", two, re.M).group(1))
            self.assertAlmostEqual(distance, math.dist(place_of(one), place_of(two)), delta=0.01 * distance)
            self.assertGreater(distance, 0)

    def test_are_kept_as_measurements_and_saved_as_tables(self):
        with self.window() as window:
            places = [MIDDLE, (MIDDLE[0] + 40, MIDDLE[1] + 20), (MIDDLE[0] + 10, MIDDLE[1] + 50)]
            for place in places[:2]:
                window.click(place)
                window.picture()
            window.key("k")
            window.key("shift+k")
            window.key("shift+k")
            for place in places:
                window.click(place)
                window.picture()
            window.key("k")
            self.assertRegex(window.copied(), r"^distance [\d.]+ ± [\d.]+\nangle [\d.]+ ± [\d.]+ °\n$")
            window.key("j")
            saved = window.saved("measurements.json", json.loads)
            table = window.saved("measurements.csv", lambda text: text.decode().splitlines())
            self.assertEqual([one["kind"] for one in saved["measurements"]], ["distance", "angle"])
            self.assertEqual([len(one["points"]) for one in saved["measurements"]], [2, 3])
            self.assertEqual([line.split(",")[0] for line in table], ["kind", "distance", "angle"])
            window.key("BackSpace")
            self.assertRegex(window.copied(), r"^distance [\d.]+ ± [\d.]+\n$")

    def test_are_marked_in_the_picture_until_the_panel_is_hidden(self):
        with self.window() as window:
            window.click(MIDDLE, button=4, times=6)  # zoom until the model is visible beside the panel too
            window.picture()
            places = [(WIDTH - 60, MIDDLE[1] + 20), (WIDTH - 30, MIDDLE[1] + 80)]

            def marked():
                pixels = lower_half(window.picture())
                at = (3 * ((y - HEIGHT // 2) * WIDTH + x) for x, y in places)
                return [tuple(pixels[i:i + 3]) == (255, 184, 102) for i in at]
            window.click(places[0])
            self.assertEqual(marked(), [True, False])
            window.click(places[1])
            self.assertEqual(marked(), [True, True])
            window.key("h")
            self.assertEqual(marked(), [False, False])

    def test_are_not_replaced_by_a_double_click(self):
        for both_in in (Window.one_frame, contextlib.nullcontext):
            with self.subTest(both_in=both_in), self.window() as window:
                window.click(MIDDLE)
                one = place_of(window.copied())
                with both_in(window):
                    window.click((MIDDLE[0] + 40, MIDDLE[1] + 20), times=2)
                window.picture()  # when the picture is complete
                window.click(MIDDLE)
                last = window.copied()
                distance = float(re.search(r"^distance ([\d.]+) ± [\d.]+$", last, re.M).group(1))
                self.assertAlmostEqual(distance, math.dist(one, place_of(last)), delta=0.01 * distance)


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
