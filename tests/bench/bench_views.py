#!/usr/bin/env python3
"""Measures bytes and triangles of a view at an error of one pixel: bench_views.py BIN_DIR STORE [STORE ...]
[--places 4]

Stores are of one model. Cameras stand at random places of its surface, at the distances below, looking down at 30 degrees. Prints a
row for each distance and store: medians over the places, and ratios to the first store at the same place.
"""
import argparse
import json
import math
import pathlib
import random
import statistics
import subprocess
import tempfile

from rows import print_row

DISTANCES = [2.4, 1.2, 0.6, 0.3, 0.06, 0.012]  # of the diagonal
PITCH = math.radians(30)
COARSE_TRIANGLES = 4000


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return [x / length for x in a] if length > 0 else None


def surface_of(bin_dir, store, folder):
    """Returns the points and triangles of a coarse cut."""
    path = folder / "coarse.obj"
    subprocess.run([bin_dir / "lodestreamd", "export", store, "--triangles", str(COARSE_TRIANGLES), "-o", path],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    points, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            triangles.append([int(word.split("/")[0]) - 1 for word in words[1:4]])
    return points, triangles


def cameras_of(points, triangles, places):
    low, high = ([pick(axis) for axis in zip(*points)] for pick in (min, max))
    diagonal = math.dist(low, high)
    draw = random.Random(1)
    while places:
        a, b, c = (points[corner] for corner in draw.choice(triangles))
        up = unit(cross(minus(b, a), minus(c, a)))
        sideways = unit(cross(up, [draw.gauss(0, 1) for _ in range(3)])) if up else None
        if not sideways:
            continue
        places -= 1
        target = [sum(corner) / 3 for corner in zip(a, b, c)]
        for share in DISTANCES:
            away = share * diagonal
            eye = [p + away * (math.sin(PITCH) * u + math.cos(PITCH) * s) for p, u, s in zip(target, up, sideways)]
            yield share, {"fov_y_deg": 45, "keys": [{"t": 0, "eye": eye, "target": target, "up": up}]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("stores", nargs="+", type=pathlib.Path, metavar="STORE")
    parser.add_argument("--places", type=int, default=4, help="of the surface (default: 4)")
    options = parser.parse_args()
    taken = {(share, store): [] for share in DISTANCES for store in options.stores}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for share, camera in cameras_of(*surface_of(options.bin_dir, options.stores[0], folder), options.places):
            (folder / "camera.json").write_text(json.dumps(camera))
            for store in options.stores:
                said = subprocess.run([options.bin_dir / "lodestream", "fetch", store, "--camera",
                                       folder / "camera.json", "--cache", "off", "--json"],
                                      check=False, capture_output=True, text=True).stdout  # 1 where the model has no more
                fetched = json.loads(said)
                taken[share, store].append((fetched["triangles"], fetched["bytes_received"]))
    for (share, store), of_places in taken.items():
        first = taken[share, options.stores[0]]
        ratios = [[mine[i] / others[i] for mine, others in zip(of_places, first)] for i in (0, 1)]
        triangles, received = (statistics.median(values) for values in zip(*of_places))
        print_row(distance=f"{share} diagonals", store=store.stem, bytes_received=received, triangles_drawn=triangles,
                  bytes_ratio=statistics.median(ratios[1]), triangles_ratio=statistics.median(ratios[0]))


if __name__ == "__main__":
    main()
