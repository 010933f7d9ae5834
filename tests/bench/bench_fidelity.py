#!/usr/bin/env python3
"""How far simplified surfaces are from their originals, as tables: bench_fidelity.py BIN_DIR PART [--triangles N] [--triangles-per-node N]

bunny        cuts of the bunny beside meshoptimizer's, and those of other simplifiers
creases      vertices of the leaves and bytes of the store by the angle from which an edge is a crease, beside none
equal_error  triangles of a sample's cuts beside simplifications of the whole model with the same error
attributes   what attributes lose with their quadrics and without
forms        two forms of attribute quadrics

Makes stores and cuts by the programs in BIN_DIR and has bench_fidelity measure them. All but equal_error take scans of the folder
LODESTREAM_TEST_DATA.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

SCANS = {"bunny": "a_bunny_zipper_ascii", "armadillo": "a_armadillo86k_le", "parasaurolophus": "b_parasaurolophus_nrm_ascii",
         "sofa": "c_sofa_texcoord_notexfile_le", "fuze": "c_fuze_spaces_le", "steampunk robot": "c_steampunk_3tex_le",
         "spot": "c_spot_wedge_texcoord_le", "jungle": "c_jungle_multitex_le", "suzanne": "c_suzanne_st_mixed_ascii"}
COUNTS = (18799, 1822, 642)  # of the bunny's reference
ERRORS = ("1e-2", "3e-3", "1e-3", "3e-4", "1e-4")
ANGLES, DEFAULT_ANGLE = (30, 40, 44, 50, 60), 44
SAME = 1e-9  # an attribute that differs by less has one value all over
ATTRIBUTES = {"colour": "colour, of 255", "normal": "normal, degrees", "texture": "texture"}


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


def print_table(heads, rows):
    for row in (heads, ["---"] * len(heads), *rows):
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
    print()


def bunny(programs, _):
    def measured(said):
        return re.findall(r"(\d+) triangles  rms (\S+) .*reference (\S+)  ours / reference (\S+)", said)

    def cuts_of(*options):
        programs.build(scan("bunny"), *options)
        cuts = [programs.export("--triangles", count) for count in COUNTS]
        return measured(programs.run("bench_fidelity", scan("bunny"), *cuts))

    print_table(("asked", "triangles", "rms", "reference", "ours / reference"), [(asked, *cut) for asked, cut in zip(COUNTS, cuts_of())])
    others = {"cluster": cuts_of("--simplifier", "cluster"),
              "the paper's operator": reversed(measured(programs.run("bench_fidelity", "--paper", scan("bunny"))))}
    print_table(("simplifier", "asked", "triangles", "rms", "rms / reference"),
                [(name, asked, triangles, rms, ratio) for name, cuts in others.items() for asked, (triangles, rms, _, ratio) in zip(COUNTS, cuts)])


def creases(programs, _):
    def taken(model, angle):
        stored = programs.build(model, "--crease-angle", angle)["bytes"]
        with open(programs.export("--error", 0), "rb") as cut:
            return int(re.search(rb"element vertex (\d+)", cut.read(1000))[1]), stored

    models = {"bunny": scan("bunny"), "armadillo": scan("armadillo"), "sample terrain, 100,000": programs.sample("terrain", "--triangles", "100000")}
    without = {name: taken(model, 180) for name, model in models.items()}
    rows = [[f"**{angle}**" if angle == DEFAULT_ANGLE else angle] for angle in ANGLES]
    for angle, row in zip(ANGLES, rows):
        for name, model in models.items():
            row.append(", ".join(f"+{100 * (now / before - 1):.1f} %" for now, before in zip(taken(model, angle), without[name])))
    print_table(("angle", *models), rows)


def equal_error(programs, options):
    model = programs.sample("asteroid", "--triangles", str(options.triangles))
    programs.build(model, "--triangles-per-node", options.triangles_per_node)
    said = programs.run("bench_fidelity", "--equal-error", model, *(programs.export("--error", error) for error in ERRORS))
    cuts = re.findall(r"(\d+) triangles  largest (\S+)  rms (\S+) of", said)
    ratios = [re.findall(r"= (\S+)|(\(too coarse\))", line) for line in said.splitlines() if "geometric mean" in line]
    columns = [[ratio or why for ratio, why in of_line] for of_line in ratios]
    means = [f"**{mean}**" for mean in re.findall(r"geometric mean (\S+)", said)]
    print_table(("asked", "triangles", "largest", "rms", "of meshoptimizer's, at equal largest", "at equal rms", "of collapse()'s, at equal largest",
                 "at equal rms"),
                [*((error, *cut, *row) for error, cut, row in zip(ERRORS, cuts, zip(*columns))), ("geometric mean", "", "", "", *means)])


def attributes(programs, _):
    models = {f"sample, {kinds}": sample_with(programs, kinds) for kinds in ("color", "normal", "normal,color")}
    models |= {name: scan(name) for name in ("parasaurolophus", "sofa", "fuze", "steampunk robot", "spot", "jungle", "suzanne")}
    rows = []
    for name, model in models.items():
        cuts = [{what: (losses, ratio) for what, losses, ratio in
                     re.findall(r"(colour|normal|texture|rms)(?: \(degrees\))? (\S+ / \S+) = (\S+)", line)}
                for line in programs.run("bench_fidelity", "--attributes", model).splitlines() if re.match(r" +\d+ \(", line)]
        surface = ", ".join(cut["rms"][1] for cut in cuts[:2])
        rows += [(name, ATTRIBUTES[what], *(" = ".join(cut[what]) for cut in cuts), surface)
                 for what in ATTRIBUTES if what in cuts[0] and float(cuts[0][what][0].split()[0]) > SAME]
    print_table(("model", "attribute", "a quarter", "a tenth", "a thirtieth", "rms of the surface, a quarter, a tenth"), rows)


def sample_with(programs, kinds):
    return programs.sample("asteroid", "--triangles", "100000", "--attributes", kinds)


def forms(programs, _):
    models = {f"sample, {kinds}": sample_with(programs, kinds) for kinds in ("color", "normal,color")}
    models |= {name: scan(name) for name in ("parasaurolophus", "spot")}
    rows = []
    for name, model in models.items():
        lines = re.findall(r"^  (\w.*?)  .* triangles  (\S+) CPU s  (.*) rms (\S+)$", programs.run("bench_fidelity", "--forms", model), re.M)
        rows += [(f"{name}, {to}", form, seconds, lost, rms) for to, (form, seconds, lost, rms) in
                 zip(("a quarter", "a quarter", "a tenth", "a tenth"), lines, strict=True)]
    print_table(("model, to", "form", "CPU seconds", "attribute", "rms"), rows)


def main():
    parts = {part.__name__: part for part in (bunny, creases, equal_error, attributes, forms)}
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
