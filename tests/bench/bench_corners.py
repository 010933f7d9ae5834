#!/usr/bin/env python3
"""Pictures of three parts with edges that are meant: bench_corners.py BIN_DIR [BIN_DIR ...] -o OUT.png

A cube, a tetrahedron and a box with a bore, built and drawn by the programs of each folder: a row a folder, so that two
versions stand above each other. Takes Debian's python3-matplotlib.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

SIDE_PX = 480


def cube():
    places = [(x, y, z) for z in (0.1, 1.1) for y in (0.05, 1.05) for x in (0.03, 1.03)]
    return places, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def tetrahedron():
    places = [(0.013, 0.021, 0.007), (1.017, 0.011, 0.003), (0.507, 0.871, 0.009), (0.503, 0.291, 0.823)]
    return places, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def bored_box(around=64):
    """Four rings: the bore's upper end, the box's upper and lower edge, the bore's lower end."""
    places = []
    for i in range(around):
        x, y = math.cos(2 * math.pi * i / around), math.sin(2 * math.pi * i / around)
        out = 2 / max(abs(x), abs(y))
        places += [(0.9 * x, 0.9 * y, 1), (out * x, out * y, 1), (out * x, out * y, 0), (0.9 * x, 0.9 * y, 0)]
    return places, [tuple(4 * (k % around) + ring % 4 for k, ring in ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)))
                    for i in range(around) for j in range(4)]


PARTS = [  # its maker, and the camera: eye and target
    ("a cube, 12 triangles", cube, [2.9, -1.6, 2.6], [0.53, 0.55, 0.55]),
    ("a tetrahedron, 4 triangles", tetrahedron, [2.2, -1.3, 1.6], [0.5, 0.35, 0.3]),
    ("a box with a bore, 512 triangles", bored_box, [5.5, -6.5, 6.2], [0, 0, 0.3]),
]


def write_ply(path, places, faces):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(places)}", *(f"property float {axis}" for axis in "xyz"),
             f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{value:.9g}" for value in place) for place in places]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def draw(bin_dir, part, folder):
    _, make, eye, target = part
    model, store, camera, picture = (folder / name for name in ("a.ply", "a.lode", "camera.json", "a.png"))
    write_ply(model, *make())
    camera.write_text(json.dumps({"fov_y_deg": 35, "keys": [{"t": 0, "eye": eye, "target": target, "up": [0, 0, 1]}]}))
    subprocess.run([bin_dir / "lodestreamd", "build", model, "-o", store, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    # An older version ends with 1 where it cannot come within a pixel, and draws what it has.
    subprocess.run([bin_dir / "lodestream", "render", store, "--camera", camera, "--size", f"{SIDE_PX}x{SIDE_PX}",
                    "-o", picture], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return pyplot.imread(picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dirs", nargs="+", type=pathlib.Path, metavar="BIN_DIR")
    parser.add_argument("-o", "--output", required=True, type=pathlib.Path)
    options = parser.parse_args()
    rows, columns = len(options.bin_dirs), len(PARTS)
    figure, places = pyplot.subplots(rows, columns, squeeze=False, figsize=(4 * columns, 4 * rows), layout="constrained")
    for row, bin_dir in enumerate(options.bin_dirs):
        for column, part in enumerate(PARTS):
            with tempfile.TemporaryDirectory() as folder:
                places[row, column].imshow(draw(bin_dir.absolute(), part, pathlib.Path(folder)))
            places[row, column].set_title(part[0])
            places[row, column].axis("off")
    figure.savefig(options.output, dpi=100)


if __name__ == "__main__":
    main()
