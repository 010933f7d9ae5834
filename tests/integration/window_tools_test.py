#!/usr/bin/python3
"""Tests of the window's sections, hidden models and measurements; see driven_window.py."""
import contextlib
import json
import math
import pathlib
import re
import subprocess
import tempfile
import urllib.request

from driven_window import BIN, HEIGHT, MIDDLE, MODELS, STORE, WIDTH, Window, WindowTest, at_rest, lower_half, main, place_in_picture, place_of
from processes import eventually, free_port, running

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


    def test_are_measured_on_their_cut(self):
        with self.window() as window:
            window.key("x")
            window.picture()
            texts = []
            for place in (MIDDLE, (MIDDLE[0] + 30, MIDDLE[1] + 20)):
                window.click(place)
                texts.append(window.copied())
                self.assertIn("\nthe section\n", texts[-1])
            ends = [place_of(text) for text in texts]
            self.assertAlmostEqual(ends[0][0], ends[1][0], places=4)  # the section is across x
            distance = float(re.search(r"^distance ([\d.]+) ", texts[1], re.M).group(1))
            self.assertAlmostEqual(distance, math.dist(*ends), delta=0.01 * distance)
            self.assertGreater(distance, 0)

    def test_stay_in_place_when_models_are_hidden(self):
        with tempfile.TemporaryDirectory() as folder, self.window(scene_in(folder)) as window:
            window.key("h")
            camera = window.recorded(lambda: None)[0]
            window.key("x")
            window.key("shift+x")  # the plane is between the models, and shows the other
            window.move(place_in_picture(camera, (4, 0, 0)))
            before = eventually(lambda: at_rest(window))
            window.key("shift+z")
            self.assertTrue(eventually(lambda: at_rest(window)) == before)
            window.key("x")
            window.key("shift+x")
            self.assertFalse(eventually(lambda: at_rest(window)) == before)


def scene_in(folder, store=STORE, between=4, targets="{}.lode", names=("one", "other")):
    """Writes a scene of models in a row along x; the first is at x = 0."""
    for name in names:
        pathlib.Path(folder, f"{name}.lode").symlink_to(store)
    scene = {"models": {name: targets.format(name) for name in names},
             "instances": [{"model": name, "position": [between * number, 0, 0]} for number, name in enumerate(names)]}
    file = pathlib.Path(folder, "scene.json")
    file.write_text(json.dumps(scene))
    return file


class HiddenModels(WindowTest):
    def test_leave_the_picture_and_the_picks_until_all_are_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.window(scene_in(folder)) as window:
                window.key("h")
                places = self.places(window)
                for name, place in places.items():
                    self.assertEqual(self.picked(window, place), name)
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

    def test_stop_streaming(self):
        port = free_port()
        with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
            listen = f"127.0.0.1:{free_port()}"
            file = scene_in(folder, MODELS / "asteroid2m.lode", 1.5, f"lode://{listen}/{{}}")
            stack.enter_context(running([BIN / "lodestreamd", "serve", folder, "--listen", listen, "--metrics", f"127.0.0.1:{port}",
                                         "--max-rate-per-connection", "30000"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

            def sent():
                with contextlib.suppress(OSError), urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10) as answer:
                    found = re.findall(r'^lodestream_model_blobs_sent_total{model="(\w+)"} (\S+)$', answer.read().decode(), re.M)
                    return {name: float(number) for name, number in found}
            eventually(lambda: sent() is not None)
            window = stack.enter_context(self.window(file, "--cache", "off", "--pixels", "0.1"))
            window.key("h")
            window.move(self.places(window, 1.5)["one"])
            window.key("z")
            window.picture()

            def rests():
                """Waits until the other model has received blobs. Returns true if this one has received none."""
                before = sent()
                eventually(lambda: sent()["other"] >= before["other"] + 3)
                return sent()["one"] == before["one"]
            eventually(rests)
            self.assertTrue(rests())

    def test_leave_their_memory_to_the_others(self):
        with tempfile.TemporaryDirectory() as folder:
            file = scene_in(folder, MODELS / "asteroid2m.lode", 1.5, names=("one", "other", "third", "fourth"))
            with self.window(file, "--pixels", "0.25", "--memory-budget", "16MiB") as window:
                window.key("h")
                place = self.places(window, 1.5)["other"]
                eventually(lambda: at_rest(window))
                before = self.error(window, place)
                window.move(place)
                window.key("shift+z")
                eventually(lambda: self.error(window, place) < 0.9 * before)

    @staticmethod
    def places(window, between=4):
        """Returns the places of scene_in()'s models in the picture."""
        camera = window.recorded(lambda: None)[0]
        return {name: place_in_picture(camera, (between * number, 0, 0)) for number, name in enumerate(("one", "other"))}

    @staticmethod
    def error(window, at):
        """Returns the error in pixels at a place."""
        window.click(at)
        window.picture()
        found = float(re.search(r"error ([\d.]+) px", window.copied()).group(1))
        window.click((2, 2))
        window.picture()
        return found

    @staticmethod
    def picked(window, at):
        """Returns the name of the model at a place, or None where there is no model."""
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

    def test_survive_escape_and_are_saved_when_the_window_closes(self):
        with self.window(stderr=subprocess.PIPE) as window, window.process.stderr as stderr:
            kept = self.keep_distance(window)
            window.click(MIDDLE)
            window.key("Escape")
            self.assertEqual(window.copied(), kept)  # without the open measurement
            self.assertEqual(window.leave(), 0)
            self.assertIn(b".measurements.csv and .json\n", stderr.read())
            saved = window.saved("measurements.json", json.loads)["measurements"]
            self.assertEqual([one["kind"] for one in saved], ["distance"])

    def test_are_saved_before_a_dropped_file_opens(self):
        with self.window() as window:
            self.keep_distance(window)
            window.drop(MODELS / "gyroid.lode")
            eventually(lambda: "gyroid" in window.xdotool("getwindowname", window.id))
            self.assertEqual(len(window.saved("measurements.json", json.loads)["measurements"]), 1)
            self.assertEqual(window.leave(), 0)
            self.assertEqual(list(window.folder.glob("*.measurements.json")), [])  # they are not saved twice

    @staticmethod
    def keep_distance(window):
        """Measures and keeps a distance. Returns the text that C copies."""
        for place in (MIDDLE, (MIDDLE[0] + 40, MIDDLE[1] + 20)):
            window.click(place)
            window.picture()
        window.key("k")
        return window.copied()

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
