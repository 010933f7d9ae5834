#!/usr/bin/python3
"""Plays one scenario of load: scenario.py NAME BIN_DIR [--short] [--store STORE] [--plot FILE]

steady              500 clients go round a model for 30 s
flash               a thousand clients come within 5 s
greedy              one client with 256 requests open among polite ones
restart             the only server is ended and started again
rolling_upgrade     two servers behind HAProxy are replaced one after the other, and no request fails
one_killed          one of two servers behind HAProxy is killed
slow                clients on a link of 2 Mbit/s, and one on a fast one
lossy               a link that loses 0, 1 and 3 % of its packets
larger_than_memory  a store of 100 MB in 48 MB of memory, from a slow disk
soak                half an hour of crowds, reloads, new certificates and stores, killed clients and a damaged store

Prints a table and writes a plot, NAME.svg, even if the scenario fails. All traffic stays on loopback or in network namespaces.
A scenario ends by itself within a bounded time and leaves nothing behind. BIN_DIR contains both programs. The scenarios slow,
lossy and larger_than_memory need root, and wan and serving_store in BIN_DIR. Exit status 1: the scenario failed; 77: a
requirement is missing; 130: Ctrl-C.
"""
import argparse
import contextlib
import os
import pathlib
import shutil
import signal
import sys
import tempfile

import control_groups
import crowds
import ends
import links
import soak
from stage import Stage

LONGEST_S, LONGEST_SOAK_S, SKIPPED = 300, 1800, 77
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM)
SCENARIOS = dict(steady=crowds.steady, flash=crowds.flash, greedy=crowds.greedy, restart=ends.restart,
                 rolling_upgrade=ends.rolling_upgrade, one_killed=ends.one_killed, slow=links.slow, lossy=links.lossy,
                 larger_than_memory=links.larger_than_memory, soak=soak.soak)
COMMANDS = {ends.rolling_upgrade: "haproxy", ends.one_killed: "haproxy", links.slow: "ip", links.lossy: "ip", soak.soak: "openssl"}
PACKAGES = dict(haproxy="haproxy", ip="iproute2", openssl="openssl")
PROGRAMS = {links.slow: "wan", links.lossy: "wan", links.larger_than_memory: "serving_store"}
MESSAGES = "lodestream_generated.py"


def missing(scenario, programs, messages):
    """Returns the requirement that is missing, or None."""
    command = COMMANDS.get(scenario)
    if command and not shutil.which(command):
        return f"Debian's package {PACKAGES[command]}"
    if scenario.__module__ == links.__name__ and os.geteuid() != 0:
        return "root, for network namespaces and control groups"
    if scenario is links.larger_than_memory and control_groups.version() is None:
        return "control groups for memory and disks, which this system has not"
    if scenario is links.larger_than_memory and os.major(os.stat(tempfile.gettempdir()).st_dev) == 0:
        return f"a disk under {tempfile.gettempdir()}, or another folder in TMPDIR"
    for file in (programs / "lodestreamd", programs / "lodestream", programs / PROGRAMS.get(scenario, "lodestreamd"), messages / MESSAGES):
        if not file.exists():
            return f"{file}: cmake --build {programs.parent} --target lodestreamd lodestream benchmarks makes it"
    return None


def left_behind():
    """Returns true if a started process still exists."""
    with contextlib.suppress(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
        return True
    return False


def end(number, _):
    """Leaves all `with` blocks, which end the processes. A second signal does not interrupt this."""
    for ending in ENDINGS:
        signal.signal(ending, signal.SIG_IGN)
    if number == signal.SIGALRM:
        sys.exit("it did not end in time")
    print(f"ended by a signal: {signal.strsignal(number)}", file=sys.stderr)
    sys.exit(128 + number)


def play(scenario, stage, plot):
    """Plays a scenario. plot: path of the plot, or None. The plot is written even if the scenario fails."""
    try:
        scenario(stage)
    finally:
        if plot and stage.plot and stage.plot.panels:
            stage.plot.write(plot)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=SCENARIOS, metavar="NAME")
    parser.add_argument("bin", type=pathlib.Path, metavar="BIN_DIR")
    parser.add_argument("--short", action="store_true", help="few clients and seconds: whether it goes as it should, no figures")
    parser.add_argument("--seconds", type=int, help="of a soak, instead of half an hour; 5 minutes and more")
    parser.add_argument("--store", help="by default a sample of 500,000 triangles, 20,000 of the short form")
    parser.add_argument("--messages", type=pathlib.Path, help="folder of lodestream_generated.py, by default that of BIN_DIR's build")
    parser.add_argument("--plot", help="its ending says what it is; default NAME.svg, none of the short form")
    options = parser.parse_args()
    scenario = SCENARIOS[options.name]
    messages = options.messages or options.bin.parent / "tests" / "load"
    if lacking := missing(scenario, options.bin, messages):
        print(f"skipped: it takes {lacking}")
        sys.exit(SKIPPED)
    for ending in ENDINGS:
        signal.signal(ending, end)
    signal.alarm((options.seconds or LONGEST_SOAK_S) + LONGEST_S if scenario is soak.soak and not options.short else LONGEST_S)
    with tempfile.TemporaryDirectory(prefix="lode-scenario-") as folder:
        with Stage(options.bin, folder, options.store, messages, options.short, options.seconds) as stage:
            play(scenario, stage, options.plot or (None if options.short else f"{options.name}.svg"))
    assert not left_behind(), "a process is left behind"


if __name__ == "__main__":
    main()
