#!/usr/bin/env python3
"""Tests of `lodestreamd serve --http` in viewers: tiles_viewers_test.py BIN MODELS

BIN has the programs, MODELS the stores of make_models.sh. Each test needs Chromium,
node, and in NODE_PATH the packages that this command installs:
  npm install playwright-core@1.65.1 three@0.187 3d-tiles-renderer@0.5.3 cesium@1.145
Without these it is skipped.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from http_served import BIN, MODELS, Served

VIEWER = pathlib.Path(__file__).resolve().parent / "tiles" / "viewer.cjs"
FOV_Y_DEG = 45


def client(*arguments):
    done = subprocess.run([str(part) for part in (BIN / "lodestream", *arguments)], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return json.loads(done.stdout)


@unittest.skipUnless(shutil.which("node"), "node is not installed")
class Viewers(unittest.TestCase):
    def test_show_in_threejs_the_triangles_and_the_picture_of_the_client(self):
        # The model's up axis y is z in the tileset.
        self.compare("three", lambda p: [p[0], -p[2], p[1]])

    def test_show_in_cesiumjs_the_triangles_and_the_picture_of_the_client(self):
        self.compare("cesium", lambda p: [p[0], -p[2], p[1]])

    def compare(self, viewer, from_model):
        store = MODELS / "painted.lode"
        key = {"t": 0, "eye": [1.9, 1.4, 3.2], "target": [0, 0, 0], "up": [0, 1, 0]}
        with tempfile.TemporaryDirectory() as name, Served(store) as server:
            camera, picture = pathlib.Path(name, "camera.json"), pathlib.Path(name, "picture.png")
            camera.write_text(json.dumps({"fov_y_deg": FOV_Y_DEG, "keys": [key]}))
            client("render", store, "--camera", camera, "--unlit", "--cache", "off", "-o", picture, "--json")
            fetched = client("fetch", store, "--camera", camera, "--cache", "off", "--json")
            view = {"url": f"http://{server.address}/painted/tileset.json", "fov_y_deg": FOV_Y_DEG, "picture": str(picture),
                    **{part: from_model(key[part]) for part in ("eye", "target", "up")}}
            done = subprocess.run(["node", str(VIEWER), viewer, json.dumps(view)], capture_output=True, text=True, timeout=900)
        if done.returncode == 77:
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 0, done.stderr)
        shown = json.loads(done.stdout)
        self.assertEqual(shown["errors"], [])
        self.assertEqual((shown["tiles"], shown["triangles"]), (fetched["nodes"], fetched["triangles"]))
        self.assertLess(shown["cover"][1], 0.001 * shown["cover"][0])
        self.assertGreater(shown["psnr_db"], 38)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
