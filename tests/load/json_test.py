#!/usr/bin/python3
"""Tests that docs/json.md names every key that `--json` prints: json_test.py BIN_DIR MODELS_DIR SOURCE_DIR"""
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest

from daemon import BIN, SOURCE, STORE, Daemon

NAMED_BY_DATA = {"reached_px_ms", "seconds_above_px", "errors_by_kind"}  # objects whose keys are data: thresholds, kinds of
                                                                         # errors
QUAD = """ply
format ascii 1.0
comment TextureFile missing.png
element vertex 4
property float x
property float y
property float z
property float s
property float t
property float quality
element face 3
property list uchar int vertex_indices
end_header
0 0 0 0 0 1
1 0 0 1 0 1
1 1 0 1 1 1
0 1 0 0 1 1
3 0 1 2
3 0 2 3
3 0 1 9
"""


def keys_of(value):
    """Returns all keys of a JSON value, at any depth, except keys that are data."""
    if isinstance(value, list):
        return set().union(*map(keys_of, value))
    if not isinstance(value, dict):
        return set()
    return set(value).union(*(keys_of(inner) for key, inner in value.items() if key not in NAMED_BY_DATA))


class JsonPage(unittest.TestCase):
    """Returns the sections of docs/json.md by command."""

    def setUp(self):
        with open(os.path.join(SOURCE, "docs", "json.md")) as page:
            parts = re.split(r"^## `(.*)`$", page.read(), flags=re.M)
        self.sections = dict(zip(parts[1::2], parts[2::2]))
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        shutil.copy(STORE, self.path("a.lode"))
        with open(self.path("quad.ply"), "w") as quad:
            quad.write(QUAD)

    def path(self, name):
        return os.path.join(self.folder, name)

    def expect_named(self, command, *arguments, option="--json", status=0):
        """Runs a command in the folder. Expects that the page names all printed keys. Returns the keys."""
        program, name = command.split()
        run = [os.path.join(BIN, program), name, *arguments, option]
        done = subprocess.run(run, cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, status, done.stderr)
        keys = keys_of([json.loads(line) for line in done.stdout.splitlines()])
        named = set(re.findall(r"`(\w+)`", self.sections[command]))
        self.assertTrue(keys, "it prints an object")
        self.assertEqual(keys - named, set(), f"{command} {' '.join(arguments)}")
        return keys

    def test_has_a_section_for_each_command_with_json(self):
        programs = {}
        for program in ("lodestreamd", "lodestream"):
            help_of = lambda *of: subprocess.run([os.path.join(BIN, program), *of, "--help"], capture_output=True, text=True).stdout
            commands = re.findall(r"^  ([a-z]+) ", help_of(), re.M)
            programs.update({f"{program} {name}": "--json " in help_of(name) for name in commands})
        self.assertGreater(len(programs), 8)
        self.assertEqual({command for command, has in programs.items() if has} - set(self.sections), set())

    def test_names_all_fields_of_server_commands(self):
        self.expect_named("lodestreamd sample", "asteroid", "--triangles", "500", "-o", "b.ply")
        self.assertIn("instances", self.expect_named("lodestreamd sample", "scene", "--triangles", "3000", "-o", "scene"))
        self.expect_named("lodestreamd build", "b.ply", "-o", "b.lode")
        self.expect_named("lodestreamd build", "b.ply", "-o", "b.lode", option="--json-progress")
        self.assertIn("against", self.expect_named("lodestreamd verify", "b.lode", "--against", "b.ply"))
        self.assertIn("fault", self.expect_named("lodestreamd verify", "b.ply", status=1))
        self.expect_named("lodestreamd export", "b.lode", "--error", "0.01", "-o", "cut.ply")
        self.expect_named("lodestreamd export", "b.lode", "--tiles", "tiles")
        self.expect_named("lodestreamd info", "b.lode", "--nodes")

    def test_names_all_fields_for_a_model_without_its_image(self):
        self.expect_named("lodestreamd doctor", "quad.ply", status=1)
        self.expect_named("lodestreamd build", "quad.ply", "-o", "quad.lode", "--skip-bad")
        self.assertIn("levels", self.expect_named("lodestreamd info", "quad.lode"))

    def test_names_all_fields_of_client_commands(self):
        coarse = ("--pixels", "8", "--cache", "off")
        self.expect_named("lodestream fetch", "a.lode", *coarse)
        self.expect_named("lodestream replay", "a.lode", *coarse)
        with Daemon("a.lode", cwd=self.folder) as daemon:
            self.expect_named("lodestream list", f"lode://{daemon.address}")
            for kind in ((), ("--full",)):
                self.expect_named("lodestream loadtest", f"lode://{daemon.address}/a", "--clients", "1", "--seconds", "1", *kind)
        if "built without OpenGL" not in subprocess.run([os.path.join(BIN, "lodestream"), "render", "--help"], capture_output=True,
                                                        text=True).stdout:
            self.assertIn("legend", self.expect_named("lodestream render", "a.lode", *coarse, "--size", "64x48", "--show", "lods", "-o",
                                                      "a.png"))


if __name__ == "__main__":
    unittest.main()
