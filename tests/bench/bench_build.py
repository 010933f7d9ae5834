#!/usr/bin/env python3
"""Measures the speed of builds by stage: bench_build.py BIN_DIR [MODEL.ply ...] [--triangles N] [--runs R]
[--threads T ...] [--beside BIN_DIR]

Without a model it makes the samples asteroid, gyroid and terrain, of N triangles each. Prints a row for each model and number of
threads, medians over R runs: million triangles per CPU second, in total and by stage; wall seconds; peak
memory; stored triangles and bytes per input triangle. With --beside, the two versions build in turns;
`cpu_ratio` is the CPU time of BIN_DIR ÷ that of the other version.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from rows import print_row

STAGES = ("scan", "dereference", "partition", "simplify", "pack")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--samples", nargs="*", default=["asteroid", "gyroid", "terrain"], help="which samples to make")
    parser.add_argument("--attributes", default="", help="of the samples: normal,color")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--beside", type=pathlib.Path, metavar="BIN_DIR")
    options = parser.parse_args()
    daemon = str(options.bin_dir / "lodestreamd")
    with tempfile.TemporaryDirectory() as folder:
        models = options.models or [sample(daemon, kind, options, folder) for kind in options.samples]
        for threads in options.threads:
            for model in models:
                report(options, model, threads, folder)


def sample(daemon, kind, options, folder):
    path = pathlib.Path(folder) / f"{kind}.ply"
    attributes = ["--attributes", options.attributes] if options.attributes else []
    subprocess.run([daemon, "sample", kind, "--triangles", str(options.triangles), *attributes, "-o", str(path)],
                   check=True, stdout=subprocess.DEVNULL)
    return path


def build(bin_dir, model, threads, folder):
    done = subprocess.run([str(bin_dir / "lodestreamd"), "build", str(model), "-o", f"{folder}/store.lode", "--threads", str(threads),
                           "--json", "--quiet"], check=True, capture_output=True)
    return json.loads(done.stdout)


def report(options, model, threads, folder):
    results, ratios = [], []
    for _ in range(options.runs):
        results.append(build(options.bin_dir, model, threads, folder))
        if options.beside:
            ratios.append(results[-1]["cpu_seconds"] / build(options.beside, model, threads, folder)["cpu_seconds"])
    triangles = results[0]["triangles"]

    def median(value):
        return statistics.median(value(result) for result in results)

    def speed(cpu_seconds):
        return triangles / cpu_seconds / 1e6

    print_row(model=model.stem, on=f"{threads} threads", all=speed(median(lambda result: result["cpu_seconds"])),
              **{stage: speed(median(lambda result: result["stages"][index]["cpu_seconds"])) for index, stage in enumerate(STAGES)},
              wall_s=median(lambda result: result["seconds"]), peak_mb=median(lambda result: result["peak_rss_bytes"]) / 1e6,
              stored_triangles=results[0]["stored_triangles"] / triangles, stored_bytes=results[0]["bytes"] / triangles,
              **({"cpu_ratio": statistics.median(ratios)} if ratios else {}))


if __name__ == "__main__":
    main()
