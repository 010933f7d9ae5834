#!/usr/bin/env python3
"""What hot functions take: bench_hot.py BIN_DIR [--repetitions N]

Runs bench_hot and bench_refine and prints their medians as a table: the time of a call, and how much is done in a second.
"""
import argparse
import json
import pathlib
import statistics
import subprocess

ROWS = (  # text, benchmarks whose figures stand in a row, what is counted in a second
    ("a payload is encoded", ("encodeAPayload",), "triangles"),
    ("a payload is decoded", ("decodeAPayload",), "triangles"),
    ("its triangles are put into clusters, in a copy", ("clusterAMesh",), "triangles"),
    ("a blob of a store is read", ("readBlobsOfAStore",), "bytes"),
    ("a store of 1,096 nodes is opened", ("openAStore",), None),
    ("64 blobs of 8 KiB, of 64 KiB are received", ("receiveBlobs/8192", "receiveBlobs/65536"), "bytes"),
    ("1,024 requests are read", ("readRequests",), "requests"),
    ("an exchange of cuts is planned, of one place, of a few parts, of all",
     ("planAnExchange/1/256", "planAnExchange/120/8", "planAnExchange/120/256"), None),
    ("it is planned and done", ("exchangeCuts/1/256", "exchangeCuts/120/8", "exchangeCuts/120/256"), None),
    ("a cut is refined that goes through 657, 2,033, 4,877 nodes of 1.4 million",
     ("refineWhileTheCameraMoves/400", "refineWhileTheCameraMoves/200", "refineWhileTheCameraMoves/120"), None),
    ("what is seen of a cut of 65,522 triangles is looked for", ("lookAtWhatIsSeen",), None),
)
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def scaled(values, unit, name):
    """The values in a unit, of two digits at least."""
    return ", ".join(f"{value / unit:.2g}" if value / unit < 10 else f"{value / unit:.0f}" for value in values) + f" {name}"


def time_of(seconds):
    unit, name = (1e-3, "ms") if max(seconds) >= 1e-4 else (1e-6, "µs")
    return scaled(seconds, unit, name)


def rate_of(rates, what):
    return scaled(rates, 1e9, "GB") if what == "bytes" else scaled(rates, 1e6, "M" if what == "requests" else "M triangles")


def medians(program, repetitions):
    """By benchmark: seconds of a call, and what it counts a second."""
    told = json.loads(subprocess.run([program, f"--benchmark_repetitions={repetitions}", "--benchmark_format=json"], check=True,
                                     stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
    runs = {}
    for run in told["benchmarks"]:
        if run["run_type"] == "iteration" and not run.get("error_occurred"):
            runs.setdefault(run["run_name"], []).append(run)
    median = lambda name, of: statistics.median(map(of, runs[name]))
    seconds = lambda run: run["real_time"] * UNITS[run["time_unit"]]
    rate = lambda run: next((run[key] for key in ("triangles", "items_per_second", "bytes_per_second") if key in run), 0.0)
    return {name: (median(name, seconds), median(name, rate)) for name in runs}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("--repetitions", type=int, default=5)
    options = parser.parse_args()
    measured = {}
    for program in ("bench_hot", "bench_refine"):
        measured |= medians(options.bin_dir / program, options.repetitions)
    print("| function | takes | a second |\n| --- | --- | --- |")
    for text, names, what in ROWS:
        if not measured.keys() >= set(names):
            continue  # it needs OpenGL, which is not here
        seconds, rates = zip(*(measured[name] for name in names))
        print(f"| {text} | {time_of(seconds)} | {rate_of(rates, what) if what else ''} |")


if __name__ == "__main__":
    main()
