#!/usr/bin/env python3
"""Measures the cost of the appearance error: bench_appearance.py LODESTREAMD [--triangles N]

Prints for each error the triangles of a cut with the appearance error ÷ those without, on the sample asteroid
and on a painted flat wall.
"""

import argparse
import json
import math
import pathlib
import struct
import subprocess
import tempfile

from rows import print_row

ERRORS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
WALL_SIDE = 400


def write_wall(path):
    """A flat square with rings, a checkerboard and a gradient painted on its vertices."""
    n = WALL_SIDE
    with open(path, "wb") as out:
        out.write(
            b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            b"property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face %d\n"
            b"property list uchar int vertex_indices\nend_header\n" % (n * n, 2 * (n - 1) ** 2)
        )
        for row in range(n):
            for column in range(n):
                x, y = column / (n - 1), row / (n - 1)
                radius = math.hypot(x - 0.5, y - 0.5)
                colour = (200, 190, 170)
                if 0.1 < radius < 0.3:
                    colour = (int(127 + 120 * math.sin(60 * radius)), 80, int(255 * x))
                if x < 0.2 and y < 0.2:
                    colour = ((int(x * 80) + int(y * 80)) % 2 * 255,) * 3
                out.write(struct.pack("<fffBBB", 10 * x, 10 * y, 0, *colour))
        for row in range(n - 1):
            for column in range(n - 1):
                a = row * n + column
                out.write(struct.pack("<BiiiBiii", 3, a, a + 1, a + n + 1, 3, a, a + n + 1, a + n))


def nodes_of(lodestreamd, model, folder):
    store = folder / "model.lode"
    subprocess.run([lodestreamd, "build", model, "-o", store, "--quiet"], check=True)
    listing = subprocess.run([lodestreamd, "info", store, "--nodes", "--json"], check=True, capture_output=True, text=True)
    nodes = {}
    for line in listing.stdout.splitlines():
        lod = json.loads(line)
        nodes.setdefault(lod["key"], []).append(lod)
    return nodes


def triangles_of_cut(nodes, error_of, allowed):
    total, open_nodes = 0, [1]
    while open_nodes:
        key = open_nodes.pop()
        lods = nodes[key]
        fine_enough = [lod for lod in lods if error_of(lod) <= allowed]
        children = [child for child in range(8 * key, 8 * key + 8) if child in nodes]
        if fine_enough or not children:
            total += (fine_enough or lods[:1])[-1]["triangles"]
        else:
            open_nodes += children
    return total


def report(name, nodes):
    box = nodes[1][0]["box"]
    diagonal = math.dist(box["min"], box["max"])
    ratios = {}
    for error in ERRORS:
        geometry = triangles_of_cut(nodes, lambda lod: lod["error"], error * diagonal)
        both = triangles_of_cut(
            nodes, lambda lod: max(lod["error"], lod["appearance_error"]), error * diagonal
        )
        ratios[f"{error:.0e}"] = both / geometry
    print_row(model=name, **ratios, geometric_mean=math.prod(ratios.values()) ** (1 / len(ratios)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lodestreamd")
    parser.add_argument("--triangles", type=int, default=2_000_000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        model = folder / "model.ply"
        for attributes in ([], ["normal"], ["color"], ["normal,color"]):
            of_sample = ["--triangles", str(options.triangles), *(["--attributes", *attributes] if attributes else [])]
            subprocess.run([options.lodestreamd, "sample", "asteroid", *of_sample, "-o", model],
                           check=True, capture_output=True)
            report(attributes[0] if attributes else "no attributes", nodes_of(options.lodestreamd, model, folder))
        write_wall(model)
        report("painted wall", nodes_of(options.lodestreamd, model, folder))


if __name__ == "__main__":
    main()
