#!/usr/bin/env python3
"""Load scenarios: bench_scenarios.py BIN_DIR [SCENARIO ...]

Plays tests/load/scenario.py, all but soak, and prints a row for each row of its tables. Each scenario writes its plot into the
working folder.
"""
import argparse
import pathlib
import re
import subprocess
import sys

from rows import print_row

SCENARIO = pathlib.Path(__file__).resolve().parent.parent / "load" / "scenario.py"
KEYS = ("visible_p50_ms", "visible_p99_ms", "visible_max_ms", "first_image_p99_ms", "single_p50_ms", "single_p99_ms", "connections_lost",
        "requests_failed", "others_get")
OF_CROWD = (3, 4, None, 6, 9, 10, 7, 12, None)
OF_END = (1, 2, 3, None, None, 8, 5, 6, None)
ROWS = {  # names of a scenario's rows, and for each key the index of its cell in the scenario's tables laid side by side
    "steady": (("500 clients, 30 s",), OF_CROWD),
    "flash": (("1,000 within 5 s",), OF_CROWD),
    "greedy": (("50 polite clients alone", "beside one with 256 requests open"), (4, 5, None, None, 1, 2, 6, None, 7)),
    "restart": (("the only server of 200, away for 2 s after its drain",), OF_END),
    "rolling_upgrade": (("two behind HAProxy, 200 clients",), OF_END),
    "one_killed": (("of two behind HAProxy, 200 clients",), OF_END),
    "slow": (("`single` on a fast link alone", "beside 20 clients on a link of 2 Mbit/s", "beside 20 full ones there"), (5, None, None, 7, 1, 2, 6, None, 4)),
    "lossy": (("4 clients over 10 Mbit/s, 50 ms, 0 % lost", "1 % lost", "3 % lost"), (4, 5, None, 6, 1, 2, 8, None, 7)),
    "larger_than_memory": (("`single` for what is in memory, alone", "beside four that read 100 MB from a disk of 20 MB/s in 48 MB"),
                           (None, None, None, None, 1, 2, None, None, 4)),
}


def play(scenario, bin_dir):
    """Returns the scenario's exit status and output. On Ctrl-C waits until the scenario has cleaned up."""
    with subprocess.Popen([SCENARIO, scenario, bin_dir], stdout=subprocess.PIPE, text=True) as playing:
        try:
            printed = playing.communicate()[0]
        except KeyboardInterrupt:
            sys.exit(playing.wait())
        return playing.returncode, printed


def tables(text):
    """Returns the rows of each Markdown table in a text, without the heads of the tables."""
    found, rows = [], None
    for line in text.splitlines():
        if re.fullmatch(r"[|\s-]*---[|\s-]*", line):
            found.append(rows := [])
        elif not line.startswith("|"):
            rows = None
        elif rows is not None:
            rows.append([cell.strip() for cell in line.strip().strip("|").split("|")])
    return found


def print_rows(scenario, printed):
    names, places = ROWS[scenario]
    for name, cells in zip(names, zip(*tables(printed), strict=True), strict=True):
        side_by_side = sum(cells, [])
        said = {key: re.search(r"[\d.,]+", side_by_side[place]) for key, place in zip(KEYS, places) if place is not None}
        print_row(scenario=scenario, what=name, **{key: float(number[0].replace(",", "")) for key, number in said.items() if number})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help=f"of {', '.join(ROWS)}; all by default")
    options = parser.parse_args()
    if unknown := set(options.scenarios) - set(ROWS):
        parser.error(f"no such scenario: {', '.join(sorted(unknown))}: of {', '.join(ROWS)}")
    missing = []
    for scenario in options.scenarios or ROWS:
        status, printed = play(scenario, options.bin_dir)
        if status != 0:
            missing.append(f"{scenario} ended with {status}: {printed}")
            continue
        print_rows(scenario, printed)
    if missing:
        sys.exit("\n".join(missing))


if __name__ == "__main__":
    main()
