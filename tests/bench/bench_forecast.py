#!/usr/bin/env python3
"""How good doctor's forecasts are: bench_forecast.py BIN_DIR [MODEL.ply ...] [--triangles N]

Without a model it takes every PLY of the folder LODESTREAM_TEST_DATA that can be built, and the samples asteroid,
gyroid and terrain of N triangles. Prints forecast ÷ actual of CPU seconds, memory, temporary disk and the store.
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
    print(f"{'model':44} {'triangles':>10} {'CPU':>6} {'memory':>7} {'store':>6}   (CPU s)")
    with tempfile.TemporaryDirectory() as folder:
        for model in options.models or list(default_models(daemon, options.triangles, folder)):
            report(daemon, model, folder)


def default_models(daemon, triangles, folder):
    data = os.environ.get("LODESTREAM_TEST_DATA")
    yield from sorted(pathlib.Path(data).glob("*.ply")) if data else []
    for kind in ["asteroid", "gyroid", "terrain"]:
        path = pathlib.Path(folder) / f"{kind}.ply"
        subprocess.run([daemon, "sample", kind, "--triangles", str(triangles), "--attributes", "normal,color", "-o",
                        str(path)], check=True, stdout=subprocess.DEVNULL)
        yield path


def report(daemon, model, folder):
    doctor = subprocess.run([daemon, "doctor", str(model), "--json"], capture_output=True, check=False)
    forecast = json.loads(doctor.stdout).get("forecast") if doctor.returncode == 0 else None
    built = subprocess.run([daemon, "build", str(model), "-o", f"{folder}/store.lode", "--json", "--quiet"],
                           capture_output=True, check=False)
    if forecast is None or built.returncode != 0:
        return
    actual = json.loads(built.stdout)
    ratios = [forecast["cpu_seconds"] / max(actual["cpu_seconds"], 1e-3),
              forecast["memory_bytes"] / actual["peak_rss_bytes"], forecast["store_bytes"] / actual["bytes"]]
    print(f"{model.name:44} {actual['triangles']:10} {ratios[0]:6.2f} {ratios[1]:7.2f} {ratios[2]:6.2f}   "
          f"({actual['cpu_seconds']:.2f})", flush=True)


if __name__ == "__main__":
    main()
