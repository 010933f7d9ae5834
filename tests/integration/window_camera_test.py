#!/usr/bin/python3
"""Tests of the window's cameras and of its light under keys and mouse; see driven_window.py."""
import json
import math
import pathlib
import re
import struct
import subprocess
import tempfile

from driven_window import (BIN, HEIGHT, MIDDLE, STORE, WIDTH, Window, WindowTest, direction, lower_half, main, moved, place_of)
from processes import display

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


if __name__ == "__main__":
    main()
