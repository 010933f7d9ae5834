#!/usr/bin/env python3
"""How good doctor's forecasts are: bench_forecast.py BIN_DIR [MODEL.ply ...] [--triangles N]

Without a model it takes every PLY of the folder LODESTREAM_TEST_DATA that can be built, and the samples asteroid,
gyroid and terrain of N triangles. Prints a table of forecast ÷ actual of CPU seconds, memory and the store: a row a
sample or model, and one for all files of the folder.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=2_000_000)
    options = parser.parse_args()
    daemon = str(options.bin_dir / "lodestreamd")
    print("| model | CPU seconds | peak memory | store |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        if options.models:
            for model in options.models:
                print_row(model.stem, [forecast(daemon, model, folder)])
            return
        print_row("files of the test data", [forecast(daemon, scan, folder) for scan in scans()])
        for kind in ("asteroid", "gyroid", "terrain"):
            print_row(f"{kind}, {options.triangles}, normals and colour", [forecast(daemon, sample(daemon, kind, options.triangles, folder), folder)])


def scans():
    data = os.environ.get("LODESTREAM_TEST_DATA")
    return sorted(pathlib.Path(data).glob("*.ply")) if data else []


def sample(daemon, kind, triangles, folder):
    path = pathlib.Path(folder) / f"{kind}.ply"
    subprocess.run([daemon, "sample", kind, "--triangles", str(triangles), "--attributes", "normal,color", "-o", str(path)],
                   check=True, stdout=subprocess.DEVNULL)
    return path


def print_row(name, ratios):
    """Of several the least and the largest; those that could not be built are left out."""
    columns = list(zip(*filter(None, ratios)))
    if columns:
        spans = (f"{min(column):.2f}" + (f" to {max(column):.2f}" if len(column) > 1 else "") for column in columns)
        print(f"| {name} | " + " | ".join(spans) + " |", flush=True)


def forecast(daemon, model, folder):
    """Ratios to what the build took; None if there is none."""
    doctor = subprocess.run([daemon, "doctor", str(model), "--json"], capture_output=True, check=False)
    foretold = json.loads(doctor.stdout).get("forecast") if doctor.returncode == 0 else None
    built = subprocess.run([daemon, "build", str(model), "-o", f"{folder}/store.lode", "--json", "--quiet"],
                           capture_output=True, check=False)
    if foretold is None or built.returncode != 0:
        return None
    actual = json.loads(built.stdout)
    return (foretold["cpu_seconds"] / max(actual["cpu_seconds"], 1e-3), foretold["memory_bytes"] / actual["peak_rss_bytes"],
            foretold["store_bytes"] / actual["bytes"])


if __name__ == "__main__":
    main()
