#!/usr/bin/env python3
"""Measures distances of simplified surfaces from their originals: bench_fidelity.py BIN_DIR PART [--triangles
N] [--triangles-per-node N]

bunny        cuts of the bunny by both simplifiers, and by meshoptimizer
creases      vertices of the leaves and bytes of the store by crease angle, ÷ those without creases
equal_error  triangles of a sample's cuts ÷ those of simplifications of the whole model with the same error

Makes stores and cuts by the programs in BIN_DIR and has bench_fidelity measure them. bunny and creases need LODESTREAM_TEST_DATA.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

from rows import print_row

SCANS = {"bunny": "a_bunny_zipper_ascii", "armadillo": "a_armadillo86k_le"}
COUNTS = (18799, 1822, 642)  # of the bunny's reference
ERRORS = ("1e-2", "3e-3", "1e-3", "3e-4", "1e-4")
ANGLES = (30, 40, 44, 50, 60)


class Programs:
    def __init__(self, bin_dir, folder):
        self.bin_dir, self.folder = bin_dir, folder

    def run(self, program, *arguments):
        return subprocess.run([self.bin_dir / program, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True).stdout

    def sample(self, kind, *options):
        path = self.folder / f"{'_'.join([kind, *options])}.ply"
        self.run("lodestreamd", "sample", kind, *options, "-o", path)
        return path

    def build(self, model, *options):
        return json.loads(self.run("lodestreamd", "build", model, "-o", self.folder / "store.lode", "--json", "--quiet", *options))

    def export(self, *options):
        path = self.folder / f"cut{'_'.join(map(str, options))}.ply"
        self.run("lodestreamd", "export", self.folder / "store.lode", *options, "-o", path)
        return path


def scan(name):
    return pathlib.Path(os.environ["LODESTREAM_TEST_DATA"], SCANS[name] + ".ply")


def measured(programs, *arguments):
    """Returns the rows that bench_fidelity prints."""
    return [json.loads(line) for line in programs.run("bench_fidelity", *arguments).splitlines()]


def bunny(programs, _):
    for simplifier in ("collapse", "cluster"):
        programs.build(scan("bunny"), "--simplifier", simplifier)
        cuts = [programs.export("--triangles", count) for count in COUNTS]
        for asked, row in zip(COUNTS, measured(programs, scan("bunny"), *cuts)):
            print_row(simplifier=simplifier, asked=f"at most {asked}", triangles=row["triangles"], rms=row["rms"], reference=row["reference"],
                      ratio=row["ratio"])


def creases(programs, _):
    def taken(model, angle):
        stored = programs.build(model, "--crease-angle", angle)["bytes"]
        with open(programs.export("--error", 0), "rb") as cut:
            return int(re.search(rb"element vertex (\d+)", cut.read(1000))[1]), stored

    models = {"bunny": scan("bunny"), "armadillo": scan("armadillo"), "terrain, 100,000": programs.sample("terrain", "--triangles", "100000")}
    for name, model in models.items():
        without = taken(model, 180)
        for angle in ANGLES:
            vertices, stored = (now / before for now, before in zip(taken(model, angle), without))
            print_row(model=name, angle=f"{angle} degrees", vertices_ratio=vertices, bytes_ratio=stored)


def equal_error(programs, options):
    model = programs.sample("asteroid", "--triangles", str(options.triangles))
    programs.build(model, "--triangles-per-node", options.triangles_per_node)
    for row in measured(programs, "--equal-error", model, *(programs.export("--error", error) for error in ERRORS)):
        print_row(**row)


def main():
    parts = {part.__name__: part for part in (bunny, creases, equal_error)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("part", choices=parts)
    parser.add_argument("--triangles", type=int, default=2_000_000, help="of equal_error")
    parser.add_argument("--triangles-per-node", type=int, default=16384, help="of equal_error")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        parts[options.part](Programs(options.bin_dir, pathlib.Path(folder)), options)


if __name__ == "__main__":
    main()
