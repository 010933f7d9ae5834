"""Reads a tileset of 3D Tiles 1.1 from a folder, as a viewer does."""
import dataclasses
import functools
import json
import math
import pathlib
import random
import struct


@dataclasses.dataclass
class Glb:
    """A GLB file: its JSON and its binary chunk."""
    json: dict
    binary: bytes

    def view(self, number):
        view = self.json["bufferViews"][number]
        begin = view.get("byteOffset", 0)
        return self.binary[begin:begin + view["byteLength"]]

    @property
    def primitive(self):
        return self.json["meshes"][0]["primitives"][0]

    @property
    def triangles(self):
        return self.json["accessors"][self.primitive["indices"]]["count"] // 3


def parse_glb(data):
    magic, version, size, json_size, json_kind = struct.unpack_from("<4sIII4s", data)
    binary_size, binary_kind = struct.unpack_from("<I4s", data, 20 + json_size)
    if (magic, version, size, json_kind, binary_kind) != (b"glTF", 2, len(data), b"JSON", b"BIN\0"):
        raise ValueError("not a GLB file of two chunks")
    if json_size % 4 or binary_size % 4 or 28 + json_size + binary_size != size:
        raise ValueError("the chunks of the GLB do not fill it")
    return Glb(json.loads(data[20:20 + json_size]), data[28 + json_size:])


class Tile:
    """A tile with the content of an LOD. References to pages are resolved."""

    def __init__(self, tileset, description, page):
        self.description, self.page, self._tileset = description, page, tileset
        self.error = description["geometricError"]
        self.box = description["boundingVolume"]["box"]
        uri = description.get("content", {}).get("uri")
        self.glb = uri and tileset.resolve(page, uri)

    @functools.cached_property
    def children(self):
        return [tile for child in self.description.get("children", []) for tile in self._tileset.tiles_of(child, self.page)]

    def distance(self, eye):
        """Returns the distance of a point from the axis-aligned box, both in the model frame."""
        half = (self.box[3], self.box[7], self.box[11])
        return math.hypot(*(max(0, abs(e - c) - h) for e, c, h in zip(eye, self.box, half)))

    def error_px(self, eye, fov_y_deg, height_px):
        distance = self.distance(eye)
        return math.inf if distance == 0 else self.error * height_px / (2 * math.tan(math.radians(fov_y_deg) / 2) * distance)


class Tileset:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.pages = {}  # by path in the folder
        self.root = Tile(self, self.page("tileset.json")["root"], "tileset.json")

    def page(self, name):
        if name not in self.pages:
            self.pages[name] = json.loads((self.folder / name).read_text())
        return self.pages[name]

    def resolve(self, page, uri):
        return str((self.folder / page).parent.joinpath(uri).resolve().relative_to(self.folder.resolve()))

    def tiles_of(self, description, page):
        """Returns the tile that a JSON object describes, or the tiles of the page that it refers to."""
        uri = description.get("content", {}).get("uri", "")
        if not uri.endswith(".json"):
            return [Tile(self, description, page)]
        name = self.resolve(page, uri)
        return [tile for child in self.page(name)["root"]["children"] for tile in self.tiles_of(child, name)]

    def tiles(self):
        """All tiles with their parents, from the root down."""
        todo = [(self.root, None)]
        while todo:
            tile, above = todo.pop()
            yield tile, above
            todo += [(child, tile) for child in tile.children]

    def glb(self, name):
        return parse_glb((self.folder / name).read_bytes())

    def cut(self, is_fine_enough):
        """The tiles that a viewer draws after it has loaded everything."""
        shown, todo = [], [self.root]
        while todo:
            tile = todo.pop()
            if not tile.children or is_fine_enough(tile):
                shown.append(tile)
            else:
                todo += tile.children
        return shown

    def random_cut(self, seed):
        """A mixture of tiles that a viewer may draw while it loads."""
        chance = random.Random(seed)
        stop = chance.uniform(0.05, 0.6)
        return self.cut(lambda tile: chance.random() < stop)

    def to_model(self, point):
        """Converts a point of the tileset's frame to the model frame."""
        m = self.root.description["transform"]
        moved = [p - t for p, t in zip(point, m[12:15])]
        return [sum(m[4 * column + row] * moved[row] for row in range(3)) for column in range(3)]  # m turns only


ROOT_KEYS = {"boundingVolume", "geometricError", "content", "children", "transform", "refine"}
TILE_KEYS = ROOT_KEYS - {"transform", "refine"}


def violations(tileset, step):
    """Returns a sentence for each violation of 3D Tiles 1.1, of refinement by REPLACE, or of docs/tiles.md."""
    above = {}  # tiles above each page's root
    for name in sorted(str(path.relative_to(tileset.folder)) for path in tileset.folder.rglob("*.json")):
        page = tileset.page(name)
        if set(page) != {"asset", "geometricError", "root"} or page["asset"]["version"] != "1.1":
            yield f"{name}: not a tileset of version 1.1"
        if page["root"].get("refine") != "REPLACE":
            yield f"{name}: its root does not say REPLACE"
        if ("transform" in page["root"]) != (name == "tileset.json"):
            yield f"{name}: transforms belong to tileset.json alone"
        yield from violations_of_tile(name, page["root"], page["geometricError"], ROOT_KEYS)
    for tile, above in tileset.tiles():
        if above is None:
            continue
        if not tile.error < above.error:
            yield f"{tile.page}: an error of {tile.error} below {above.error}"
        for k, half in enumerate((3, 7, 11)):
            if abs(tile.box[k] - above.box[k]) + tile.box[half] > above.box[half] + step / 2:
                yield f"{tile.page}: a box exceeds the box above"


def violations_of_tile(page, tile, error_above, keys):
    if not set(tile) <= keys or not {"boundingVolume", "geometricError"} <= set(tile):
        yield f"{page}: a tile with the keys {sorted(tile)}"
    box = tile["boundingVolume"].get("box", [])
    if len(box) != 12 or min(box[3], box[7], box[11]) <= 0 or any(box[k] for k in (4, 5, 6, 8, 9, 10)):
        yield f"{page}: the box {box} has no volume"
    error = tile["geometricError"]
    if not 0 <= error <= error_above or float(f"{error:.9g}") != error:
        yield f"{page}: the error {error} below {error_above}"
    if tile.get("children") == [] or set(tile.get("content", {"uri"})) != {"uri"}:
        yield f"{page}: empty children or foreign content"
    for child in tile.get("children", []):
        yield from violations_of_tile(page, child, error, TILE_KEYS)
