#!/usr/bin/env python3
"""The table of load scenarios: bench_scenarios.py BIN_DIR [SCENARIO ...]

Plays tests/load/scenario.py, all but soak, each of which writes its plot into the working folder, and prints a line of what each
of its rows says, with blanks for what it does not tell.
"""
import argparse
import pathlib
import subprocess
import sys

from all import tables

SCENARIO = pathlib.Path(__file__).resolve().parent.parent / "load" / "scenario.py"
HEADS = ("scenario", "visible, median", "p99", "longest", "first image, p99", "single, median", "p99", "connections lost", "requests failed",
         "others get")
OF_CROWD = (3, 4, None, 6, 9, 10, 7, 12, None)
OF_END = (1, 2, 3, None, None, 8, 5, 6, None)
ROWS = {  # names of a scenario's rows, and for each head after the first which cell of its own tables it is, these laid side by side
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
    """Returns the scenario's exit status and what it printed. Ctrl-C reaches the scenario too: it is waited for until it has cleared its stage."""
    with subprocess.Popen([SCENARIO, scenario, bin_dir], stdout=subprocess.PIPE, text=True) as playing:
        try:
            printed = playing.communicate()[0]
        except KeyboardInterrupt:
            sys.exit(playing.wait())
        return playing.returncode, printed


def rows_of(scenario, printed):
    names, places = ROWS[scenario]
    for number, cells in enumerate(zip(*(table.rows.values() for table in tables(printed)), strict=True)):
        side_by_side = sum(cells, ())
        name = f"`{scenario}`: {names[number]}" if number == 0 else f"… {names[number]}"
        yield name, *("" if place is None else side_by_side[place] for place in places)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help=f"of {', '.join(ROWS)}; all by default")
    options = parser.parse_args()
    if unknown := set(options.scenarios) - set(ROWS):
        parser.error(f"no table is made of {', '.join(sorted(unknown))}: of {', '.join(ROWS)}")
    print(f"| {' | '.join(HEADS)} |\n|{' --- |' * len(HEADS)}")
    missing = []
    for scenario in options.scenarios or ROWS:
        status, printed = play(scenario, options.bin_dir)
        if status != 0:
            missing.append(f"{scenario} ended with {status}: {printed}")
            continue
        for row in rows_of(scenario, printed):
            print(f"| {' | '.join(row)} |", flush=True)
    if missing:
        sys.exit("\n".join(missing))


if __name__ == "__main__":
    main()
