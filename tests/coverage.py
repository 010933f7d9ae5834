#!/usr/bin/env python3
"""Prints how many lines of parsing, store, session and refinement the tests run: tests/coverage.py [BUILD] [--lines]

BUILD (build/coverage) is where `cmake --workflow --preset coverage` ran. --lines also lists the lines that no test ran, as
FILE:FIRST-LAST.
"""

import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

PARTS = {
    "parsing": ("server/ingest/ply/", "proto/", "common/codec/hierarchy_page", "common/codec/texture_set", "common/image/",
                "common/codec/draco_decoder", "server/serve/net/proxy_header", "server/serve/session/token_file",
                "server/serve/ops/health_endpoint"),
    "store": ("server/store/",),
    "session": ("server/serve/", "client/core/session/"),
    "refinement": ("client/core/",),
}


def part_of(file):
    """The first part that lists the file."""
    return next((part for part, places in PARTS.items() if file.startswith(places)), None)


def read_counts(notes):
    """(file, line, runs) for the lines of one object."""
    run = subprocess.run(["gcov", "--json-format", "--stdout", notes], capture_output=True, text=True, check=True)
    root = os.getcwd() + os.sep
    return [(entry["file"].removeprefix(root), line["line_number"], line["count"])
            for said in run.stdout.splitlines() for entry in json.loads(said)["files"] for line in entry["lines"]
            if part_of(entry["file"].removeprefix(root))]


def runs_of(lines):
    """Ranges of line numbers: '3-5', '9' for 3, 4, 5, 9."""
    spans = []
    for line in sorted(lines):
        if spans and line == spans[-1][1] + 1:
            spans[-1][1] = line
        else:
            spans.append([line, line])
    return [f"{first}-{last}" if last > first else str(first) for first, last in spans]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", nargs="?", default="build/coverage")
    parser.add_argument("--lines", action="store_true")
    options = parser.parse_args()
    build = pathlib.Path(options.build).absolute()
    os.chdir(pathlib.Path(__file__).resolve().parent.parent)
    notes = sorted(build.rglob("*.gcda"))
    if not notes:
        sys.exit(f"coverage: {build} has run nothing; run: cmake --workflow --preset coverage")

    counts = collections.Counter()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for read in pool.map(read_counts, notes):
            for file, line, count in read:
                counts[file, line] += count
    print("| part | lines | run |\n| --- | --- | --- |")
    for part in PARTS:
        lines = {at: count for at, count in counts.items() if part_of(at[0]) == part}
        ran = sum(count > 0 for count in lines.values())
        print(f"| {part} | {len(lines)} | {100 * ran / max(len(lines), 1):.1f} % |")
    if options.lines:
        missed = collections.defaultdict(list)
        for (file, line), count in counts.items():
            if count == 0:
                missed[file].append(line)
        for file in sorted(missed):
            print(f"{file}:{','.join(runs_of(missed[file]))}")


if __name__ == "__main__":
    main()
