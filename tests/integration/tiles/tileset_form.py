"""States what the JSON of a tileset must hold by 3D Tiles 1.1, as far as Lodestream uses it.

Written from the specification's text, without its published JSON schemas: they are under CC BY 4.0, unlike this project, and
accept what viewers do not, such as any `refine` and any transform.
"""
import json
import re

NAME = re.compile(r"[A-Za-z0-9._-]+(/[A-Za-z0-9._-]+)*")  # a path that no viewer needs to encode or resolve


def parse(text):
    """Parses JSON. Refuses what JSON does not have: NaN, infinities and repeated members."""
    def refuse(constant):
        raise ValueError(f"{constant} is no JSON number")

    def members(pairs):
        if len({name for name, _ in pairs}) != len(pairs):
            raise ValueError(f"a repeated member in {[name for name, _ in pairs]}")
        return dict(pairs)
    return json.loads(text, parse_constant=refuse, object_pairs_hook=members)


def faults_of_tileset(document):
    """Returns a sentence for each place where a tileset has another form."""
    yield from faults_of_members("the tileset", document, {"asset": dict, "geometricError": float, "root": dict}, {})
    asset = document.get("asset")
    if isinstance(asset, dict):
        yield from faults_of_members("asset", asset, {"version": str}, {"generator": str, "tilesetVersion": str})
        if asset.get("version") != "1.1":
            yield f"asset: version {asset.get('version')!r}"
    if is_number(document.get("geometricError")) and document["geometricError"] < 0:
        yield "the tileset: a negative geometricError"
    root = document.get("root")
    if isinstance(root, dict):
        if "refine" not in root:
            yield "root: no refine"
        yield from faults_of_tile("root", root)


def faults_of_tile(place, tile):
    yield from faults_of_members(place, tile, {"boundingVolume": dict, "geometricError": float},
                                 {"content": dict, "children": list, "refine": str, "transform": list})
    if is_number(tile.get("geometricError")) and tile["geometricError"] < 0:
        yield f"{place}: a negative geometricError"
    if tile.get("refine", "REPLACE") not in ("ADD", "REPLACE"):
        yield f"{place}: refine {tile['refine']!r}"
    yield from faults_of_volume(f"{place}.boundingVolume", tile.get("boundingVolume"))
    yield from faults_of_transform(f"{place}.transform", tile.get("transform"))
    uri = ""
    if isinstance(tile.get("content"), dict):
        yield from faults_of_members(f"{place}.content", tile["content"], {"uri": str}, {})
        uri = str(tile["content"].get("uri"))
        if not NAME.fullmatch(re.sub(r"^(\.\./)+", "", uri)) or not uri.endswith((".glb", ".json")):
            yield f"{place}.content: the uri {uri!r}"
    if not isinstance(tile.get("children", []), list):
        return
    if "children" in tile and not tile["children"]:
        yield f"{place}: an empty list of children"
    if "children" in tile and uri.endswith(".json"):
        yield f"{place}: children beside an external tileset"
    for number, child in enumerate(tile.get("children", [])):
        if isinstance(child, dict):
            yield from faults_of_tile(f"{place}.children[{number}]", child)
        else:
            yield f"{place}.children[{number}]: no object"


def faults_of_members(place, found, needed, allowed):
    for name in needed.keys() - found.keys():
        yield f"{place}: no {name}"
    for name, value in found.items():
        kind = {**needed, **allowed}.get(name)
        if kind is None:
            yield f"{place}: the foreign member {name}"
        elif not (is_number(value) if kind is float else isinstance(value, kind)):
            yield f"{place}.{name}: {value!r}"


def faults_of_volume(place, volume):
    """A box: its centre, and three half axes that span a volume."""
    if not isinstance(volume, dict):
        return
    box = volume.get("box")
    if set(volume) != {"box"} or not isinstance(box, list) or len(box) != 12 or not all(map(is_number, box)):
        yield f"{place}: no box of twelve numbers"
    elif determinant(box[3:6], box[6:9], box[9:12]) <= 0:
        yield f"{place}: a box without volume"


def faults_of_transform(place, matrix):
    """An affine matrix by columns that mirrors nothing."""
    if not isinstance(matrix, list):
        return
    if len(matrix) != 16 or not all(map(is_number, matrix)):
        yield f"{place}: no matrix of sixteen numbers"
    elif matrix[3::4] != [0, 0, 0, 1] or determinant(matrix[0:3], matrix[4:7], matrix[8:11]) <= 0:
        yield f"{place}: not affine, or it mirrors"


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def determinant(a, b, c):
    return sum(a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]) for i in range(3))
