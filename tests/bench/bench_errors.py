#!/usr/bin/env python3
"""Compares stored errors with measured errors: bench_errors.py BIN_DIR [MODEL.ply ...] [--nodes N ...]
[--seeds N ...] [--quick]

Builds each model, ten samples and four sets of loose pieces, with node capacities from 256 to 16384 triangles.
`verify --against --lods all` measures every LOD with each seed. Prints a row for each store: number of LODs,
smallest and median ratio of stored to measured error (over the seeds: the smallest of the smallest, the largest
of the medians), number of LODs with a ratio below 1, and CPU seconds of the verification per million triangles.
The last row is for all stores. Exits with 1 if a store is not sound. Names files that cannot be built on
stderr.
"""
import argparse
import json
import math
import pathlib
import random
import resource
import statistics
import subprocess
import sys
import tempfile

from rows import print_row

SAMPLES = [  # triangles, seed, attributes, triangles a node
    (300_000, 4242, "normal", 16384), (300_000, 31337, "", 4096), (250_000, 99, "uv", 16384), (200_000, 7, "color", 1024),
    (200_000, 8, "normal,color", 8192), (150_000, 9, "", 512), (100_000, 10, "color", 256), (120_000, 11, "", 2048),
    (200_000, 12, "normal", 4096), (100_000, 13, "", 16384)]
SOUPS = [(2000, 1, 512), (4000, 2, 1024), (8000, 3, 4096), (12000, 4, 16384)]  # pieces, seed, triangles a node


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    parser.add_argument("--nodes", type=int, nargs="*", default=[256, 1024, 4096, 16384], help="of the models")
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--quick", action="store_true", help="the first four samples and two soups alone")
    options = parser.parse_args()
    bench = Bench(str(options.bin_dir / "lodestreamd"), options.seeds)
    for model in options.models:
        for nodes in options.nodes:
            bench.measure(model.stem, model, nodes)
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder) / "made.ply"
        for triangles, seed, attributes, nodes in SAMPLES[:4] if options.quick else SAMPLES:
            command = [bench.daemon, "sample", "asteroid", "--triangles", str(triangles), "--seed", str(seed), "-o", str(made)]
            subprocess.run(command + (["--attributes", attributes] if attributes else []), check=True,
                           stdout=subprocess.DEVNULL)
            bench.measure(f"sample, {triangles}, seed {seed}{', ' + attributes if attributes else ''}", made, nodes)
        for pieces, seed, nodes in SOUPS[:2] if options.quick else SOUPS:
            write_soup(made, pieces, seed)
            bench.measure(f"soup of {pieces} pieces, seed {seed}", made, nodes)
    bench.summarize()
    sys.exit(1 if bench.unsound else 0)


class Bench:
    def __init__(self, daemon, seeds):
        self.daemon, self.seeds = daemon, seeds
        self.rows, self.unsound = [], 0

    def measure(self, name, model, nodes):
        with tempfile.TemporaryDirectory() as folder:
            store = f"{folder}/store.lode"
            built = subprocess.run([self.daemon, "build", str(model), "-o", store, "--triangles-per-node", str(nodes), "--skip-bad",
                                    "--json", "--quiet"], capture_output=True, text=True)
            if built.returncode != 0:
                print(f"{name}: not built: {built.stderr.strip().splitlines()[-1]}", file=sys.stderr)
                return
            triangles = json.loads(built.stdout)["triangles"]
            before = cpu_seconds()
            reports = [self.verify(store, model, seed) for seed in self.seeds]
            cpu = (cpu_seconds() - before) / len(self.seeds)
        faults = [report["fault"] for report in reports if not report["sound"]]
        if faults:
            self.unsound += 1
            print(f"{name}, {nodes} a node: not sound: {faults[0]}", file=sys.stderr)
            return
        found = [report["against"] for report in reports]
        if found[0]["lods_sampled"] == 0:
            return
        row = (found[0]["lods_sampled"], min(f["least_ratio"] for f in found), max(f["median_ratio"] for f in found),
               max(f["lods_below"] for f in found))
        self.rows.append(row)
        print_row(model=name, nodes=f"{nodes} a node", lods=row[0], least=row[1], median=row[2], below=row[3],
                  cpu_s_a_million=cpu / triangles * 1e6)

    def verify(self, store, model, seed):
        done = subprocess.run([self.daemon, "verify", store, "--against", str(model), "--lods", "all", "--seed", str(seed),
                               "--json", "--quiet"], capture_output=True, text=True)
        return json.loads(done.stdout)

    def summarize(self):
        if not self.rows:
            return
        print_row(model="all", stores=len(self.rows), lods=sum(row[0] for row in self.rows), least=min(row[1] for row in self.rows),
                  median=statistics.median(row[2] for row in self.rows), below=sum(row[3] for row in self.rows), unsound=self.unsound)


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def write_soup(path, pieces, seed):
    """Makes strips of 1 to 100 triangles, far apart. Every fourth strip shares a vertex with the previous one."""
    dice = random.Random(seed)
    points, triangles = [], []

    def direction():
        while True:
            d = [dice.uniform(-1, 1) for _ in range(3)]
            length = math.hypot(*d)
            if length > 0.1:
                return [x / length for x in d]

    for piece in range(pieces):
        along, across = direction(), direction()
        at = list(points[-1]) if piece % 4 == 3 else [dice.uniform(0, 1000) for _ in range(3)]
        first = len(points) - 1 if piece % 4 == 3 else len(points)
        if piece % 4 != 3:
            points.append(list(at))
        points.append([x + 0.5 * y for x, y in zip(at, across)])
        a, b = first, len(points) - 1
        for step in range(1 + int(dice.random() ** 3 * 100)):
            at = [x + dice.uniform(0.2, 0.35) * y for x, y in zip(at, along)]
            points.append([x + (0.5 * y if step % 2 else 0) for x, y in zip(at, across)])
            triangles.append((a, b, len(points) - 1) if step % 2 == 0 else (b, a, len(points) - 1))
            a, b = b, len(points) - 1
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
                   f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines("%.6f %.6f %.6f\n" % tuple(point) for point in points)
        file.writelines("3 %d %d %d\n" % triangle for triangle in triangles)


if __name__ == "__main__":
    main()
