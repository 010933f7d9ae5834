#!/usr/bin/env python3
"""Tests of `lodestreamd export --tiles`: tiles_test.py BIN MODELS

BIN has the programs and draco_triangles, MODELS the stores of make_models.sh. If node finds the module gltf-validator, which
NODE_PATH may name, the GLB files are validated too: npm install gltf-validator@2.0.0-dev.3.10
"""
import array
import collections
import filecmp
import functools
import json
import operator
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "tiles"))
from tileset import Tileset, violations  # noqa: E402
from tileset_form import faults_of_tileset, parse  # noqa: E402

BIN, MODELS = pathlib.Path(), pathlib.Path()
CLOSED = ("painted", "gyroid")
HEIGHT_PX, FOV_Y_DEG = 720, 45
VALIDATE = """
const validator = require('gltf-validator'), fs = require('fs');
(async () => {
  for (const file of fs.readFileSync(0, 'utf8').split('\\n').filter(Boolean)) {
    const read = uri => Promise.resolve(new Uint8Array(fs.readFileSync(require('path').join(file, '..', uri))));
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { externalResourceFunction: read });
    for (const m of issues.messages) if (m.severity < 2) console.log(file, m.code, m.message, m.pointer);
  }
})();
"""


def run(*command, **options):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=300, **options)


def lodestreamd(*arguments):
    done = run(BIN / "lodestreamd", *arguments)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return done


def write_png(path, size, texel):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(channel for x in range(size) for channel in texel(x, y)) for y in range(size))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def export(store, folder, *options):
    return json.loads(lodestreamd("export", store, "--tiles", folder, "--json", "--quiet", *options).stdout)


def step_of(store):
    """Step of the store's lattice, from its header."""
    return struct.unpack_from("<d", store.read_bytes(), 80)[0]


def stores():
    return sorted(MODELS.glob("*.lode"))


def decoded(glbs, folder):
    """Positions as raw bits and triangles of each GLB, decoded as viewers do."""
    paths = []
    for number, glb in enumerate(glbs):
        paths.append(pathlib.Path(folder, f"{number}.drc"))
        paths[-1].write_bytes(glb.view(0))
    done = subprocess.run([BIN / "draco_triangles", *paths], capture_output=True, check=True, timeout=300)
    at = 0
    for _ in glbs:
        vertices, triangles = struct.unpack_from("<II", done.stdout, at)
        end = at + 8 + 12 * vertices + 12 * triangles
        numbers = array.array("I", done.stdout[at + 8:end])
        yield list(zip(*[iter(numbers[:3 * vertices])] * 3)), list(zip(*[iter(numbers[3 * vertices:])] * 3))
        at = end


def open_edges(meshes):
    uses = collections.Counter()
    for positions, triangles in meshes:
        for a, b, c in triangles:
            for ends in ((a, b), (b, c), (c, a)):
                uses[frozenset(positions[end] for end in ends)] += 1
    return sum(count % 2 for count in uses.values())


class TilesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def camera(self, store, distance):
        """Writes a camera that sees the whole model. The distance is in model diagonals. Returns the eye."""
        box = json.loads(lodestreamd("info", store, "--json").stdout)["box"]
        diagonal = sum((b - a) ** 2 for a, b in zip(box["min"], box["max"])) ** 0.5
        target = [(a + b) / 2 for a, b in zip(box["min"], box["max"])]
        eye = [t + distance * diagonal * d for t, d in zip(target, (0.48, 0.36, 0.8))]
        (self.folder / "camera.json").write_text(json.dumps(
            {"fov_y_deg": FOV_Y_DEG, "keys": [{"t": 0, "eye": eye, "target": target, "up": [0, 1, 0]}]}))
        return eye

    def fetched(self, store, pixels):
        """Returns the summary of `lodestream fetch` after it has converged at the camera."""
        fetched = json.loads(run(BIN / "lodestream", "fetch", store, "--camera", self.folder / "camera.json", "--pixels", pixels,
                                 "--size", f"1280x{HEIGHT_PX}", "--cache", "off", "--json").stdout)
        self.assertTrue(fetched["converged"])
        return fetched

    def validate(self, stores):
        """Validates all GLB files of stores. Skips the test without gltf-validator."""
        if not shutil.which("node") or run("node", "-e", "require('gltf-validator')").returncode != 0:
            self.skipTest("node does not find gltf-validator: npm install gltf-validator@2.0.0-dev.3.10, and set NODE_PATH")
        files = []
        for store in stores:
            export(store, self.folder / store.stem)
            files += sorted((self.folder / store.stem / "g").iterdir())
        done = run("node", "-e", VALIDATE, input="\n".join(map(str, files)))
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)


class Export(TilesTest):
    def test_follows_the_rules_of_3d_tiles(self):
        for store in stores():
            with self.subTest(store.name):
                folder = self.folder / store.stem
                report = export(store, folder)
                tileset = Tileset(folder)
                self.assertEqual(list(violations(tileset, step_of(store))), [])
                tiles = [tile for tile, _ in tileset.tiles()]
                files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
                self.assertEqual(files, {tile.glb for tile in tiles if tile.glb} | set(tileset.pages))
                self.assertEqual(report["tiles"], len(tiles))
                self.assertEqual(report["glb_files"] + report["json_files"], len(files))
                sizes = collections.Counter()
                for name in files:
                    sizes[name[-4:]] += (folder / name).stat().st_size
                self.assertEqual((report["json_bytes"], report["glb_bytes"]), (sizes["json"], sizes[".glb"]))

    def test_has_json_of_the_form_of_3d_tiles(self):
        for store in stores():
            for number, options in enumerate(([], ["--up", "z"], ["--at", "8.5,47.4,400"])):
                folder = self.folder / f"{store.stem}.{number}"
                export(store, folder, *options)
                for page in folder.rglob("*.json"):
                    self.assertEqual(list(faults_of_tileset(parse(page.read_text()))), [], page)

    def test_has_all_triangles_of_the_leaves(self):
        for store in stores():
            info = json.loads(lodestreamd("info", store, "--json").stdout)
            export(store, self.folder / store.stem)
            tileset = Tileset(self.folder / store.stem)
            finest = tileset.cut(lambda tile: False)
            self.assertEqual(sum(tileset.glb(tile.glb).triangles for tile in finest), info["triangles"], store.name)

    def test_writes_the_same_bytes_with_any_number_of_threads(self):
        store = MODELS / "painted.lode"
        export(store, self.folder / "one", "--threads", 1)
        export(store, self.folder / "many", "--threads", 7)
        names = sorted(str(path.relative_to(self.folder / "one")) for path in (self.folder / "one").rglob("*.*"))
        self.assertEqual(names, sorted(str(path.relative_to(self.folder / "many")) for path in (self.folder / "many").rglob("*.*")))
        self.assertEqual(filecmp.cmpfiles(self.folder / "one", self.folder / "many", names, shallow=False)[0], names)

    def test_says_what_it_wrote_in_a_line(self):
        done = lodestreamd("export", MODELS / "gyroid.lode", "--tiles", self.folder / "t", "--up", "z")
        self.assertRegex(done.stdout, r"^\S+/t: \d+ tiles in \d+ GLB files and \d+ JSON files, .*B; z is up\n$")
        self.assertEqual(done.stderr, "")

    def test_keeps_a_folder_with_files(self):
        (self.folder / "t").mkdir()
        (self.folder / "t/mine").write_text("x")
        done = run(BIN / "lodestreamd", "export", MODELS / "gyroid.lode", "--tiles", self.folder / "t")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"lodestreamd: {self.folder}/t exists and is not an empty folder; "
                                      "name a new folder, or remove this one\n")
        self.assertEqual([path.name for path in self.folder.rglob("*")], ["t", "mine"])

    def test_refuses_wrong_options_with_a_remedy(self):
        for options, said in ((["--up", "w"], "write --up y or z"), (["--at", "1,2"], "write --at LONGITUDE,LATITUDE,HEIGHT"),
                              (["--at", "0,91,0"], "write --at"), (["-o", "x.ply"], "--output excludes --tiles"),
                              (["--error", "0"], "Exactly 1 option")):
            done = run(BIN / "lodestreamd", "export", MODELS / "gyroid.lode", "--tiles", self.folder / "t", *options)
            self.assertEqual(done.returncode, 2, options)
            self.assertIn(said, done.stderr)
            self.assertEqual(list(self.folder.iterdir()), [])

    def test_leaves_nothing_after_a_signal(self):
        process = subprocess.Popen([BIN / "lodestreamd", "export", MODELS / "asteroid2m.lode", "--tiles", self.folder / "t",
                                    "--threads", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while not any(self.folder.rglob("*.glb")) and time.monotonic() < deadline:
            os.sched_yield()
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGTERM)
        self.assertEqual(said, "lodestreamd: interrupted; nothing was written, start it again\n")
        self.assertEqual(list(self.folder.iterdir()), [])


class Form(unittest.TestCase):
    """The check of a tileset's JSON finds each fault."""

    GOOD = {"asset": {"version": "1.1", "tilesetVersion": "a"}, "geometricError": 8, "root": {
        "boundingVolume": {"box": [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]}, "geometricError": 4.5, "refine": "REPLACE",
        "transform": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 5, 6, 7, 1], "content": {"uri": "../g/a.1.glb"},
        "children": [{"boundingVolume": {"box": [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]}, "geometricError": 0, "content": {"uri": "p/1.json"}}]}}

    def test_a_tileset_without_faults_has_none(self):
        self.assertEqual(list(faults_of_tileset(self.GOOD)), [])

    def test_each_fault_is_named(self):
        for said, place, value in (
                ("no asset", "asset", None), ("asset: version '1.0'", "asset version", "1.0"),
                ("asset: the foreign member gltfUpAxis", "asset gltfUpAxis", "Z"),
                ("tileset: no geometricError", "geometricError", None), ("negative", "geometricError", -1),
                ("geometricError: '8'", "geometricError", "8"), ("geometricError: True", "geometricError", True),
                ("foreign member properties", "properties", {}), ("root: no refine", "root refine", None),
                ("refine 'replace'", "root refine", "replace"), ("no boundingVolume", "root boundingVolume", None),
                ("no box", "root boundingVolume", {"sphere": [0, 0, 0, 1]}), ("no box", "root boundingVolume box", [0] * 11),
                ("without volume", "root boundingVolume box", [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1]),
                ("sixteen", "root transform", [1] * 15), ("affine", "root transform 7", 1), ("mirrors", "root transform 0", -1),
                ("uri '/g/a.glb'", "root content uri", "/g/a.glb"), ("uri 'http://a/b.glb'", "root content uri", "http://a/b.glb"),
                ("uri 'a b.glb'", "root content uri", "a b.glb"), ("uri 'a.b3dm'", "root content uri", "a.b3dm"),
                ("no uri", "root content uri", None), ("foreign member url", "root content url", "a.glb"),
                ("empty list", "root children", []), ("children: {}", "root children", {}), ("no object", "root children 0", "a"),
                ("children[0]: no geometricError", "root children 0 geometricError", None),
                ("external tileset", "root children 0 children", [self.GOOD["root"]])):
            document = json.loads(json.dumps(self.GOOD))
            *path, last = (int(part) if part.isdigit() else part for part in place.split())
            parent = functools.reduce(operator.getitem, path, document)
            if value is None:
                del parent[last]
            else:
                parent[last] = value
            faults = list(faults_of_tileset(document))
            self.assertTrue(any(said in fault for fault in faults), f"{place} = {value}: {faults}")

    def test_json_that_viewers_refuse_is_no_json(self):
        for text in ('{"a": NaN}', '{"a": -Infinity}', '{"a": 1, "a": 2}', '{"a": 1,}'):
            self.assertRaises(ValueError, parse, text)


class Textures(TilesTest):
    """Tiles of models with images."""

    def stores(self):
        """Builds the test data's models with images, and a generated model that repeats an image and has an atlas."""
        ply = self.folder / "own.ply"
        corners = [(x, y, 0) for y in range(9) for x in range(9)]
        faces = [(i, i + 1, i + 10, i + 9) for i in range(72) if i % 9 != 8]
        uv = {0: lambda c: (c[0] * 0.9, c[1] * 0.7), 1: lambda c: (0.3 + c[0] / 99, 0.4 + c[1] / 99)}
        rows = [f"4 {' '.join(map(str, face))} 8 " + " ".join(f"{a} {b}" for a, b in (uv[face[0] % 2](corners[i]) for i in face)) +
                f" {face[0] % 2}" for face in faces]
        ply.write_text("\n".join([
            "ply", "format ascii 1.0", "comment TextureFile a.png", "comment TextureFile b.png", "element vertex 81",
            "property float x", "property float y", "property float z", "element face 64",
            "property list uchar int vertex_indices", "property list uchar float texcoord", "property int texnumber", "end_header",
            *(" ".join(map(str, corner)) for corner in corners), *rows, ""]))
        for name, size, texel in (("a.png", 40, lambda x, y: (x * 6, y * 6, 99, 255)),
                                  ("b.png", 600, lambda x, y: (x % 256, y % 256, (x + y) % 256, 255 if x % 64 > 8 else 0))):
            write_png(self.folder / name, size, texel)
        data = pathlib.Path(os.environ.get("LODESTREAM_TEST_DATA", "/nonexistent"))
        for path in [ply, *sorted(data.glob("c_*tex*.ply"))]:
            store = self.folder / f"{path.stem}.lode"
            lodestreamd("build", path, "-o", store, "--quiet")
            yield store

    def test_are_images_inside_or_beside_the_tiles(self):
        kinds = set()
        for store in self.stores():
            folder = self.folder / store.stem
            report = export(store, folder)
            tileset, named = Tileset(folder), set()
            for page in folder.rglob("*.json"):
                self.assertEqual(list(faults_of_tileset(parse(page.read_text()))), [], page)
            for path in sorted((folder / "g").iterdir()):
                glb = tileset.glb(f"g/{path.name}")
                for image in glb.json.get("images", []):
                    data = (path.parent / image["uri"]).read_bytes() if "uri" in image else bytes(glb.view(image["bufferView"]))
                    named |= {image["uri"][3:]} if "uri" in image else set()
                    kinds.add(("shared" if "uri" in image else "atlas", data[:3] == b"\xff\xd8\xff"))
                    self.assertTrue(data[:3] == b"\xff\xd8\xff" or data[8:12] == b"WEBP", path)
            beside = {str(path.relative_to(folder)) for path in folder.glob("i/*")}
            self.assertEqual(beside, named, store.name)
            self.assertEqual((report["image_files"], report["image_bytes"]),
                             (len(beside), sum((folder / name).stat().st_size for name in beside)))
        self.assertEqual({place for place, _ in kinds}, {"shared", "atlas"})

    def test_have_at_most_half_more_bytes_than_the_client_receives_from_near(self):
        scan = pathlib.Path(os.environ.get("LODESTREAM_TEST_DATA", "/nonexistent"), "c_jungle_multitex_le.ply")
        if not scan.exists():
            self.skipTest("LODESTREAM_TEST_DATA has no jungle")
        store = self.folder / "jungle.lode"
        lodestreamd("build", scan, "-o", store, "--quiet")
        report = export(store, self.folder / "tiles")
        self.camera(store, 0.7)
        fetched = self.fetched(store, 1)
        self.assertEqual(fetched["triangles"], json.loads(lodestreamd("info", store, "--json").stdout)["triangles"])
        self.assertLessEqual(report["glb_bytes"] + report["json_bytes"] + report["image_bytes"], 1.5 * fetched["bytes_received"])

    def test_are_valid(self):
        self.validate(self.stores())


class Glbs(TilesTest):
    def test_have_the_counts_and_bounds_of_their_streams(self):
        for name in CLOSED:
            export(MODELS / f"{name}.lode", self.folder / name)
            tileset = Tileset(self.folder / name)
            glbs = [tileset.glb(tile.glb) for tile, _ in tileset.tiles() if tile.glb]
            for glb, (positions, triangles) in zip(glbs, decoded(glbs, self.folder)):
                self.assertEqual(glb.triangles, len(triangles))
                accessor = glb.json["accessors"][glb.primitive["attributes"]["POSITION"]]
                self.assertEqual(accessor["count"], len(positions))
                floats = [struct.unpack("<3f", struct.pack("<3I", *p)) for p in positions]
                self.assertEqual(accessor["min"], [min(axis) for axis in zip(*floats)])
                self.assertEqual(accessor["max"], [max(axis) for axis in zip(*floats)])

    def test_have_no_errors_and_no_warnings(self):
        self.validate(stores())


class Cuts(TilesTest):
    """Sets of tiles that a viewer draws."""

    def test_have_no_open_edge_in_any_mixture(self):
        for name in CLOSED:
            export(MODELS / f"{name}.lode", self.folder / name)
            tileset = Tileset(self.folder / name)
            sizes = set()
            for seed in range(8):
                glbs = [tileset.glb(tile.glb) for tile in tileset.random_cut(seed) if tile.glb]
                self.assertEqual(open_edges(decoded(glbs, self.folder)), 0, f"{name}, seed {seed}")
                sizes.add(sum(glb.triangles for glb in glbs))
            self.assertGreater(len(sizes), 3)

    def test_are_those_of_fetch_at_the_same_camera(self):
        # At larger errors a cut of the tileset can be finer than the store's, because some LODs do not become
        # tiles.
        for name, distance, pixels in (("painted", 3, 1), ("painted", 2, 1), ("painted", 1.5, 1), ("gyroid", 3, 1),
                                       ("gyroid", 2, 1), ("asteroid2m", 1.3, 0.25)):
            with self.subTest(f"{name} from {distance} diagonals"):
                store, folder = MODELS / f"{name}.lode", self.folder / name
                if not folder.exists():
                    export(store, folder, "--up", "y")
                self.assertEqual(self.cut_of_tileset(Tileset(folder), self.camera(store, distance), pixels),
                                 self.cut_of_fetch(store, pixels))

    def cut_of_tileset(self, tileset, eye, pixels):
        in_model = tileset.to_model([eye[0], -eye[2], eye[1]])  # the tileset's root turns y up to z up
        cut = tileset.cut(lambda tile: tile.error_px(in_model, FOV_Y_DEG, HEIGHT_PX) <= pixels)
        return len(cut), sum(tileset.glb(tile.glb).triangles for tile in cut if tile.glb)

    def cut_of_fetch(self, store, pixels):
        fetched = self.fetched(store, pixels)
        return fetched["nodes"], fetched["triangles"]


if __name__ == "__main__":
    BIN, MODELS = map(pathlib.Path, sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
