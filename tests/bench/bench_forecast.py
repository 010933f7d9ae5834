#!/usr/bin/env python3
"""Measures the accuracy of doctor's forecasts: bench_forecast.py BIN_DIR [MODEL.ply ...] [--triangles N]

Without a model, uses every PLY in the folder LODESTREAM_TEST_DATA that can be built, and the samples
asteroid, gyroid and terrain of N triangles. Prints a row for each model: forecast ÷ actual value of CPU
seconds, memory and store size.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile

from rows import print_row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=2_000_000)
    options = parser.parse_args()
    daemon = str(options.bin_dir / "lodestreamd")
    with tempfile.TemporaryDirectory() as folder:
        if options.models:
            for model in options.models:
                print_forecast(model.stem, daemon, model, folder)
            return
        for scan in scans():
            print_forecast(scan.stem, daemon, scan, folder)
        for kind in ("asteroid", "gyroid", "terrain"):
            model = sample(daemon, kind, options.triangles, folder)
            print_forecast(f"{kind}, {options.triangles}, normals and colour", daemon, model, folder)


def scans():
    data = os.environ.get("LODESTREAM_TEST_DATA")
    return sorted(pathlib.Path(data).glob("*.ply")) if data else []


def sample(daemon, kind, triangles, folder):
    path = pathlib.Path(folder) / f"{kind}.ply"
    subprocess.run([daemon, "sample", kind, "--triangles", str(triangles), "--attributes", "normal,color", "-o", str(path)],
                   check=True, stdout=subprocess.DEVNULL)
    return path


def print_forecast(name, daemon, model, folder):
    """Prints the row of a model; nothing if the model cannot be built."""
    if ratios := forecast(daemon, model, folder):
        print_row(model=name, **dict(zip(("cpu_seconds", "peak_memory", "store"), ratios)))


def forecast(daemon, model, folder):
    """Returns the ratios of forecast to actual values; None if the model cannot be built."""
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
