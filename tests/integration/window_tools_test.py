#!/usr/bin/python3
"""Tests of the window's sections, hidden models and measurements; see driven_window.py."""
import contextlib
import json
import math
import pathlib
import re
import shutil
import subprocess
import tempfile

from driven_window import HEIGHT, MIDDLE, STORE, WIDTH, Window, WindowTest, at_rest, lower_half, main, place_in_picture, place_of
from processes import eventually

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


if __name__ == "__main__":
    main()
