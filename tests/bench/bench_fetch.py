#!/usr/bin/env python3
"""Measures the time to the first picture of a store over loopback: bench_fetch.py BIN_DIR STORE [--runs R]

`lodestream fetch` starts its own server and ends when the first camera's cut is within a pixel. Medians over R runs.
"""
import argparse
import json
import pathlib
import statistics
import subprocess

from rows import print_row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=10)
    options = parser.parse_args()
    command = [options.bin_dir / "lodestream", "fetch", options.store, "--cache", "off", "--json"]
    runs = [json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout) for _ in range(options.runs)]
    median = lambda what: statistics.median(run[what] for run in runs)
    print_row(model=options.store.stem, first_image_ms=median("first_image_ms"), converged_ms=median("converged_ms"),
              bytes_received=median("bytes_received"), of_cut=median("bytes_received") / median("final_cut_bytes"), triangles=median("triangles"))


if __name__ == "__main__":
    main()
