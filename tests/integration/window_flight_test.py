#!/usr/bin/python3
"""Tests of the window during a flight and while it is minimized; see driven_window.py."""
import json
import pathlib
import subprocess
import tempfile

from driven_window import BIN, STORE, Window, WindowTest, main, served_without_blobs
from processes import display, eventually


class Flight(WindowTest):
    def test_flies_the_requested_laps_and_prints_their_frame_times(self):
        path = {"fov_y_deg": 45, "keys": [{"t": t, "eye": [8 - t / 4, 0, 3], "target": [0, 0, 0], "up": [0, 0, 1]} for t in (0, 4)]}
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

    def test_keeps_the_requested_threshold(self):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, STORE, "--pixels", "3", "--laps", "1", "--json")
            flown = json.loads(subprocess.run(window.command, env=window.environment, check=True, capture_output=True, timeout=120).stdout)
        self.assertEqual({frame["threshold_px"] for frame in flown["frames"]}, {3})

    def test_prints_the_flown_frames_and_fails_if_interrupted(self):
        with self.window(STORE, "--laps", "1000", "--json", is_open=False, stdout=subprocess.PIPE) as window:
            eventually(lambda: len(window.recorded(lambda: None)) > 1)  # the camera moves without input
            window.key("Escape")
            with window.process.stdout as said:  # the output is larger than a pipe's buffer
                flown = json.load(said)
            self.assertEqual(window.process.wait(timeout=120), 1)
        self.assertTrue(flown["interrupted"])
        self.assertGreater(len(flown["frames"]), 1)

    def test_is_not_hidden_by_the_help_of_the_first_start(self):
        with self.window(STORE, "--laps", "1000", is_open=False) as window:
            window.leave()  # a key would close the help, and the cache would remember this
            self.assertEqual(list(window.folder.rglob("help-seen")), [])

    def test_fails_if_closed_before_it_begins(self):
        with served_without_blobs() as target, self.window(target, "--laps", "1", is_open=False) as window:
            self.assertEqual(window.leave(), 1)

    def test_fails_if_the_timeout_ends_before_the_first_picture(self):
        with served_without_blobs() as target:
            self.refused(target, "--cache", "off", "--timeout", "3")

    def test_fails_if_the_cache_has_no_first_picture(self):
        with served_without_blobs() as target, tempfile.TemporaryDirectory() as cache:
            self.refused(target, "--cache", cache, "--timeout", "3")  # the cache now has the model's summary
            self.refused(target, "--cache", cache, "--offline")

    def refused(self, target, *options):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, target, "--laps", "1", *options)
            ended = subprocess.run(window.command, env=window.environment, capture_output=True, text=True, timeout=120)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("no first picture", ended.stderr)


class Minimized(WindowTest):
    def test_window_ends_a_flight_at_its_timeout(self):
        self.refused("--laps", "1")

    def test_window_ends_at_the_timeout_of_its_screenshot(self):
        self.refused("--screenshot", "a.png")

    def refused(self, *options):
        with tempfile.TemporaryDirectory() as folder, display() as screen:
            window = Window(screen, folder, STORE, "--timeout", "1", *options)
            ended = subprocess.run(window.command, env=dict(window.environment, LD_PRELOAD=BIN / "libminimized_window.so"),
                                   cwd=folder, capture_output=True, text=True, timeout=30)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("its window is minimized", ended.stderr)


if __name__ == "__main__":
    main()
