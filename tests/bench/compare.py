#!/usr/bin/env python3
"""Prints results of benchmarks as a table: compare.py NOW [BEFORE]

A file contains the output of a benchmark: one JSON object per line, or the file of Google Benchmark's
--benchmark_out. Rows with the same name are runs of one measurement; the table shows their medians. With two
files, the table shows both and the ratio NOW ÷ BEFORE.
"""
import argparse
import json
import pathlib
import statistics

TIME_UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def rows_of(text):
    """Reads the rows of a file in either format. Skips the aggregates of Google Benchmark."""
    try:
        benchmarks = json.loads(text)["benchmarks"]
    except (json.JSONDecodeError, KeyError, TypeError):
        return [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    rows = []
    for run in benchmarks:
        if run.get("run_type") == "aggregate":
            continue
        row = {"name": run.get("run_name", run["name"]), "cpu_s": run["cpu_time"] * TIME_UNITS[run["time_unit"]]}
        rows.append(row | {key: run[key] for key in ("items_per_second", "bytes_per_second") if key in run})
    return rows


def is_figure(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def medians(rows):
    """Returns the medians by name and key."""
    figures = {}
    for row in rows:
        name = ", ".join(str(value) for value in row.values() if not is_figure(value) and value is not None)
        for key, value in row.items():
            if is_figure(value):
                figures.setdefault((name, key), []).append(value)
    return {place: statistics.median(values) for place, values in figures.items()}


def print_table(heads, rows):
    for cells in (heads, ["---"] * len(heads), *rows):
        print("| " + " | ".join(cells) + " |")


def print_medians(now):
    keys = list(dict.fromkeys(key for _, key in now))
    names = list(dict.fromkeys(name for name, _ in now))
    print_table(["", *keys], [[name, *(f"{now[name, key]:.5g}" if (name, key) in now else "" for key in keys)] for name in names])


def print_ratios(now, before):
    rows = []
    for (name, key), value in now.items():
        old = before.get((name, key))
        if old is not None:
            rows.append([name, key, f"{old:.5g}", f"{value:.5g}", f"{value / old:.3f}" if old else ""])
    print_table(["", "figure", "before", "now", "now ÷ before"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("now", type=pathlib.Path)
    parser.add_argument("before", type=pathlib.Path, nargs="?")
    options = parser.parse_args()
    now = medians(rows_of(options.now.read_text()))
    if not now:
        parser.error(f"{options.now} has no rows")
    if options.before:
        print_ratios(now, medians(rows_of(options.before.read_text())))
    else:
        print_medians(now)


if __name__ == "__main__":
    main()
