#!/usr/bin/env python3
"""Measures builds in parts, as on a cluster: bench_cluster.py BIN_DIR [--triangles N] [--tasks N ...]
[--runs R] [--json]

Makes an asteroid, builds it whole and in parts, and checks that the bytes are equal. Each part runs alone, with
one thread; figures are CPU seconds, the least of R runs, and peak memory in MB. `path` is prepare, the slowest
task and finish: the time that a cluster with a node for each task needs at least. `speedup` is whole ÷ path, `sum`
all parts ÷ whole, `balance` the slowest task ÷ the mean task. The work folder is measured after prepare and after
the last task, in bytes per input triangle.

With 8 tasks, sum must be at most 1.05, balance at most 1.25 and speedup at least 3.5; otherwise, or if bytes
differ, the script exits with 1. The limits are for 10 million triangles. --json prints rows for compare.py.
"""
import argparse
import filecmp
import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

from rows import print_row

GATED_TASKS = 8
GATES = {"sum": ("at most", 1.05), "balance": ("at most", 1.25), "speedup": ("at least", 3.5)}
COLUMNS = ("tasks", "prepare", "slowest", "fastest", "finish", "sum", "balance", "path", "speedup", "prepare_mb", "task_mb", "finish_mb",
           "prepared_bytes", "work_bytes")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=10_000_000)
    parser.add_argument("--tasks", type=int, nargs="*", default=[1, 2, 4, 8])
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, pathlib.Path(folder))
        whole = bench.build_whole()
        report(options, model="asteroid", on="whole", cpu_s=whole["cpu_seconds"], peak_mb=megabytes(whole))
        missed = []
        if not options.json:
            print("| " + " | ".join(COLUMNS) + " |\n" + "| --- " * len(COLUMNS) + "|")
        for tasks in options.tasks:
            row = bench.build_in_parts(tasks, whole["cpu_seconds"])
            report(options, model="asteroid", on=f"{tasks} tasks", **row)
            missed += missed_gates(row) if tasks == GATED_TASKS else []
    for text in missed:
        print(text, file=sys.stderr)
    sys.exit(1 if missed else 0)


def report(options, **row):
    if options.json:
        print_row(**row)
    elif "tasks" in row:
        print("| " + " | ".join(f"{row[key]:.4g}" for key in COLUMNS) + " |", flush=True)
    else:
        print(f"whole: {row['cpu_s']:.4g} CPU seconds, {row['peak_mb']:.0f} MB\n", flush=True)


def missed_gates(row):
    for name, (side, limit) in GATES.items():
        if row[name] > limit if side == "at most" else row[name] < limit:
            yield f"{GATED_TASKS} tasks: {name} is {row[name]:.3f}; it must be {side} {limit}"


def megabytes(result):
    return result["peak_rss_bytes"] / 1e6


class Bench:
    def __init__(self, options, folder):
        self.daemon, self.runs, self.folder = str(options.bin_dir / "lodestreamd"), options.runs, folder
        self.input, self.whole, self.parted = (folder / name for name in ("asteroid.ply", "whole.lode", "parted.lode"))
        self.work = folder / ".parted.lode.building"
        sampled = subprocess.run([self.daemon, "sample", "asteroid", "--triangles", str(options.triangles), "-o", str(self.input), "--json"],
                                 check=True, capture_output=True)
        self.triangles = json.loads(sampled.stdout)["triangles"]

    def run(self, output, *arguments):
        done = subprocess.run([self.daemon, "build", str(self.input), "-o", str(output), "--threads", "1", "--quiet", "--json", *arguments],
                              check=True, capture_output=True)
        return json.loads(done.stdout)

    def build_whole(self):
        return min((self.run(self.whole) for _ in range(self.runs)), key=lambda result: result["cpu_seconds"])

    def build_in_parts(self, tasks, whole_cpu_s):
        runs = [self.run_parts(tasks) for _ in range(self.runs)]
        prepare, *simplify, finish = (min(part, key=lambda result: result["cpu_seconds"]) for part in zip(*(run["parts"] for run in runs)))
        times = [task["cpu_seconds"] for task in simplify]
        ends = prepare["cpu_seconds"] + finish["cpu_seconds"]
        path = ends + max(times)
        return {"tasks": tasks, "prepare": prepare["cpu_seconds"], "slowest": max(times), "fastest": min(times),
                "finish": finish["cpu_seconds"], "sum": (ends + sum(times)) / whole_cpu_s, "balance": max(times) / statistics.mean(times),
                "path": path, "speedup": whole_cpu_s / path, "prepare_mb": megabytes(prepare),
                "task_mb": max(megabytes(task) for task in simplify), "finish_mb": megabytes(finish),
                "prepared_bytes": runs[0]["prepared_bytes"] / self.triangles, "work_bytes": runs[0]["work_bytes"] / self.triangles}

    def run_parts(self, tasks):
        self.parted.unlink(missing_ok=True)
        shutil.rmtree(self.work, ignore_errors=True)
        parts = [self.run(self.parted, "--part", "prepare", "--tasks", str(tasks))]
        prepared_bytes = self.work_bytes()
        parts += [self.run(self.parted, "--part", "simplify", "--tasks", str(tasks), "--task", str(task)) for task in range(tasks)]
        work_bytes = self.work_bytes()
        parts.append(self.run(self.parted, "--part", "finish", "--tasks", str(tasks)))
        if not filecmp.cmp(self.parted, self.whole, shallow=False):
            sys.exit(f"the store of {tasks} tasks differs from the store of a whole build")
        return {"parts": parts, "prepared_bytes": prepared_bytes, "work_bytes": work_bytes}

    def work_bytes(self):
        return sum(file.stat().st_size for file in self.work.rglob("*") if file.is_file())


if __name__ == "__main__":
    main()
