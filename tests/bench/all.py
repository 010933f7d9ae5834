#!/usr/bin/env python3
"""The benchmarks whose tables stand in docs/benchmarks.md, and what has moved: all.py BIN_DIR [BENCH ...] [--runs R] [--write]

Runs each bench R times, prints its tables with the medians of all figures, and compares them with those of
docs/benchmarks.md, which it finds by the heads of the columns and the first cells of the rows. A figure has moved if it differs by
more than what the runs differ by among themselves, and by more than a twentieth. --write puts the medians in the place of
the figures that moved; read the text around them then. The programs of a release build are in BIN_DIR; LODESTREAM_TEST_DATA
names a folder of scans. Some benches need root, for network namespaces. An hour or more, on a machine with nothing else to do.
"""
import argparse
import os
import pathlib
import re
import shlex
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
DOCUMENT = HERE.parent.parent / "docs" / "benchmarks.md"
NOISE = 0.05  # of a figure: what differs by less is not called moved, however alike the runs are
NUMBER = re.compile(r"(?<![\w.])\d[\d,]*(?:\.\d+)?")
BENCHES = {  # {bin}, {store}: a store of the asteroid of 20 million triangles, {scans}: PLY files
    "build": "bench_build.py {bin} --threads 2 --runs 1",
    "forecast": "bench_forecast.py {bin}",
    "errors": "bench_errors.py {bin} {scans} --nodes 512 4096",
    "hot": "bench_hot.py {bin}",
    "link": "bench_link.py {bin} {store} --runs 1",
    "paths": "bench_moving.py paths {bin} {store}",
    **{part: "bench_serving.py {bin} " + part
       for part in ("throughput", "tls", "fairness", "clients", "idle", "cold", "latency", "urgent")},
}


class Table:
    """Rows of text by the heads of their columns. A row's name is its first cells, as far as they hold no figure that was measured."""

    def __init__(self, head):
        self.head, self.rows = head, {}

    @staticmethod
    def cells(line):
        return tuple(cell.strip() for cell in line.strip().strip("|").split("|"))

    def names(self):
        """How many cells name a row: those up to the last that makes the rows differ."""
        count = 1
        while count < len(self.head) and len({row[:count] for row in self.rows.values()}) < len(self.rows):
            count += 1
        return count

    def named(self):
        """Rows by their names, in which 1,000 is 1000."""
        count = self.names()
        plain = lambda cell: re.sub(r"(?<=\d),(?=\d{3})", "", cell)
        return {tuple(map(plain, row[:count])): (number, row[count:]) for number, row in self.rows.items()}


def tables(text):
    """Every table of a text in Markdown, with its rows by the numbers of their lines."""
    found, lines = [], text.splitlines()
    for number, line in enumerate(lines):
        if re.fullmatch(r"[|\s-]*---[|\s-]*", line) and number > 0 and lines[number - 1].startswith("|"):
            found.append(Table(Table.cells(lines[number - 1])))
            row = number + 1
            while row < len(lines) and lines[row].startswith("|"):
                found[-1].rows[row] = Table.cells(lines[row])
                row += 1
    return found


def figures(cell):
    return [float(figure.replace(",", "")) for figure in NUMBER.findall(cell)]


def with_figures(cell, values):
    """The cell with other figures, each as precise as it was."""
    values = iter(values)

    def other(match):
        places = len(match[0].partition(".")[2])
        return f"{next(values):{',' if ',' in match[0] else ''}.{places}f}"

    return NUMBER.sub(other, cell)


def merge(outputs):
    """Of several runs' tables one, in whose cells each figure is (median, largest difference among the runs)."""
    merged = []
    for same in zip(*map(tables, outputs)):
        rows = [table.named() for table in same]
        cells = {}
        for name, (_, first) in rows[0].items():
            if not all(name in row for row in rows):
                continue
            for place, cell in enumerate(first):
                runs = [figures(row[name][1][place]) for row in rows]
                if len({len(run) for run in runs}) == 1:
                    cells[name, place] = (cell, [(statistics.median(values), max(values) - min(values)) for values in zip(*runs)])
        merged.append((same[0], cells))
    return merged


def compare(table, cells, document):
    """@return (row, column, text in the document, text now, line) of each cell of which a figure has moved; None if no table there
    has this head and one of these rows."""
    known = next((other for other in document if other.head == table.head and set(other.named()) & set(table.named())), None)
    if known is None:
        return None
    moved, heads = [], table.head[table.names():]
    for (name, place), (_, now) in cells.items():
        if name not in known.named():
            continue
        line, row = known.named()[name]
        before = figures(row[place])
        if len(before) == len(now) and any(abs(median - old) > max(spread, NOISE * old) for (median, spread), old in zip(now, before)):
            moved.append((name, heads[place], row[place], with_figures(row[place], (median for median, _ in now)), line))
    return moved


def write(moved):
    lines = DOCUMENT.read_text().splitlines()
    for name, head, before, now, line in moved:
        head_line = line
        while not re.fullmatch(r"[|\s-]*---[|\s-]*", lines[head_line]):
            head_line -= 1
        column = Table.cells(lines[head_line - 1]).index(head, len(name))
        cells = list(Table.cells(lines[line]))
        assert cells[column] == before, (name, head)
        cells[column] = now
        lines[line] = "| " + " | ".join(cells) + " |"
    DOCUMENT.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("benches", nargs="*", metavar="BENCH", help=f"of {', '.join(BENCHES)}; all by default")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="put what has moved into docs/benchmarks.md")
    options = parser.parse_args()
    for unknown in set(options.benches) - set(BENCHES):
        parser.error(f"no bench {unknown}: there are {', '.join(BENCHES)}")
    moved, failed, unknown, document = [], [], [], tables(DOCUMENT.read_text())
    with tempfile.TemporaryDirectory() as folder:
        places = {"bin": options.bin_dir.resolve(), "store": f"{folder}/asteroid20.lode", "scans": scans()}
        for name in options.benches or BENCHES:
            if "{store}" in BENCHES[name]:
                make_store(options.bin_dir, folder)
            print(f"## {name}\n", flush=True)
            outputs = [run(BENCHES[name].format(**places)) for _ in range(options.runs)]
            if None in outputs:
                failed.append(name)
                continue
            print(outputs[-1])
            for table, cells in merge(outputs):
                found = compare(table, cells, document)
                if found is None:
                    unknown.append(f"{name} ({table.head[0]})")
                else:
                    moved += found
    print(f"\n{len(moved)} cells have moved" + (":" if moved else ""))
    for name, head, before, now, _ in moved:
        print(f"  {', '.join(name)}: {head}: {before} → {now}")
    if options.write:
        write(moved)
    complaints = [f"{', '.join(failed)} failed; what each says of it is above"] if failed else []
    if unknown:
        complaints.append(f"no table of docs/benchmarks.md has the head and a row of those of {', '.join(unknown)}")
    if complaints:
        sys.exit(f"all.py: {'; '.join(complaints)}")


def scans():
    data = os.environ.get("LODESTREAM_TEST_DATA")
    return " ".join(shlex.quote(str(path)) for path in sorted(pathlib.Path(data).glob("*.ply"))) if data else ""


def make_store(bin_dir, folder):
    model, store = (f"{folder}/asteroid20.{ending}" for ending in ("ply", "lode"))
    for command in (["sample", "asteroid", "--triangles", "20000000", "-o", model], ["build", model, "-o", store, "--quiet"]):
        subprocess.run([bin_dir / "lodestreamd", *command], check=True, stdout=subprocess.DEVNULL)


def run(command):
    """What it has printed; None if it failed: the others go on."""
    done = subprocess.run([sys.executable, *shlex.split(command)], cwd=HERE, stdout=subprocess.PIPE, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


if __name__ == "__main__":
    main()
