#!/usr/bin/env python3
"""The benchmarks whose tables stand in docs/benchmarks.md, and what has moved: all.py BIN_DIR [BENCH ...] [--runs R] [--write]

Runs each bench R times, prints its tables with the medians of all figures, and compares them with those of
docs/benchmarks.md. There a comment above each table names its benches, or says that it is made by hand; columns are found by
their heads and rows by their first cells, and the document may have more of both. A figure has moved if it differs by
more than what the runs differ by among themselves, and by more than a twentieth. --write puts the medians in the place of
the figures that moved; read the text around them then. The programs of a release build are in BIN_DIR; LODESTREAM_TEST_DATA
names a folder of scans. Some benches need root, for network namespaces. Some hours, on a machine with nothing else to do.
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
MADE_BY = re.compile(r"<!-- table: (.*) -->")
BY_HAND = "by hand"
MODELS = {  # by the names of files: what sample takes, and build
    "asteroid": ("asteroid --triangles 2000000", ""),
    "asteroid_4096": ("asteroid --triangles 2000000", "--triangles-per-node 4096"),
    "asteroid1": ("asteroid --triangles 1000000", ""),
    "asteroid1_8192": ("asteroid --triangles 1000000", "--triangles-per-node 8192"),
    "asteroid20": ("asteroid --triangles 20000000", ""),
    "gyroid": ("gyroid --triangles 1000000", ""),
    "terrain": ("terrain --triangles 1000000", ""),
    "a2": ("asteroid --triangles 2000000 --attributes normal,color", ""),
    "a20": ("asteroid --triangles 20000000 --attributes normal,color", ""),
    "coloured": ("asteroid --triangles 100000 --attributes color", ""),
    "shaded": ("asteroid --triangles 100000 --attributes normal,color", ""),
    "closed": ("asteroid --triangles 500000 --attributes normal,color", ""),
    "closed_2048": ("asteroid --triangles 500000 --attributes normal,color", "--triangles-per-node 2048"),
}
BENCHES = {  # scripts beside this file, or programs; {bin}: their folder, {scans}: PLY files of the test data, NAME.lode and NAME.ply: MODELS
    "build": "bench_build.py {bin} --threads 2 --runs 1",
    "forecast": "bench_forecast.py {bin}",
    "errors": "bench_errors.py {bin} {scans} --nodes 512 4096",
    "hot": "bench_hot.py {bin}",
    "collapse": "bench_collapse",
    **{part: "bench_fidelity.py {bin} " + part for part in ("bunny", "creases", "equal_error", "attributes", "forms")},
    "equal_error_10": "bench_fidelity.py {bin} equal_error --triangles 10000000",
    "equal_error_512": "bench_fidelity.py {bin} equal_error --triangles 10000000 --triangles-per-node 512",
    "views": "bench_views.py {bin} asteroid.lode asteroid_4096.lode",
    "pictures": "bench_pictures.py {bin} shaded.ply coloured.ply --painted 100000 500000",
    "background": "bench_background closed.lode closed_2048.lode 12",
    "frames": "bench_frames asteroid.lode",
    "window": "bench_window.py {bin} a2.lode a20.lode",
    "fetch": "bench_fetch.py {bin} asteroid.lode",
    "seen": "bench_seen asteroid.lode gyroid.lode terrain.lode",
    "link": "bench_link.py {bin} asteroid20.lode --runs 1",
    "paths": "bench_moving.py paths {bin} asteroid20.lode",
    "leaps": "bench_moving.py leaps {bin} asteroid20.lode --seconds 100 --replay --pixels 1 --memory-budget 48M",
    "faults": "bench_moving.py faults {bin} asteroid1.lode asteroid1_8192.lode --seconds 150",
    "scenarios": "bench_scenarios.py {bin}",
    **{part: "bench_serving.py {bin} " + part
       for part in ("throughput", "tls", "fairness", "clients", "idle", "cold", "latency", "cores", "urgent")},
}


class Table:
    """Rows of text by the heads of their columns. A row's name is its first cells, as far as they hold no figure that was measured."""

    def __init__(self, head, made_by=()):
        self.head, self.made_by, self.rows = head, made_by, {}

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
            made_by = MADE_BY.fullmatch(lines[number - 2]) if number > 1 else None
            found.append(Table(Table.cells(lines[number - 1]), made_by[1].split(", ") if made_by else ()))
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


def columns_in(table, other):
    """Where the columns of a table are in another, which may have more between them; None if one is not there."""
    places = []
    for head in table.head:
        if head not in other.head[places[-1] + 1 if places else 0:]:
            return None
        places.append(other.head.index(head, places[-1] + 1 if places else 0))
    return places


def in_document(table, bench, document):
    """The table there that this bench makes, and where its columns are."""
    for other in document:
        columns = columns_in(table, other)
        if bench in other.made_by and columns and set(other.named()) & set(table.named()):
            return other, columns
    return None, None


def compare(table, cells, known, columns):
    """@return (row, column, text in the document, text now, line, number of the column there) of each cell of which a figure has
    moved."""
    moved, names = [], table.names()
    for (name, place), (text_now, now) in cells.items():
        if name not in known.named():
            continue
        line, _ = known.named()[name]
        column = columns[names + place]
        text = known.rows[line][column]
        before = figures(text)
        if len(before) != len(now):
            moved.append((name, known.head[column], text, text_now, line, column))
        elif any(abs(median - old) > max(spread, NOISE * old) for (median, spread), old in zip(now, before)):
            moved.append((name, known.head[column], text, with_figures(text, (median for median, _ in now)), line, column))
    return moved


def write(moved):
    lines = DOCUMENT.read_text().splitlines()
    for name, head, before, now, line, column in moved:
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
        for name in options.benches or BENCHES:
            command = BENCHES[name].format(bin=shlex.quote(str(options.bin_dir.resolve())), scans=scans())
            make_models(command, options.bin_dir.resolve(), folder)
            print(f"## {name}\n", flush=True)
            outputs = [run(command, options.bin_dir.resolve(), folder) for _ in range(options.runs)]
            if None in outputs:
                failed.append(name)
                continue
            print(outputs[-1])
            missed = [table for table in document if name in table.made_by]
            for table, cells in merge(outputs):
                known, columns = in_document(table, name, document)
                if known is None:
                    unknown.append(f"{name} ({table.head[0]})")
                else:
                    moved += compare(table, cells, known, columns)
                    missed = [other for other in missed if other is not known]
            failed += [f"{name} (its table of {table.head[0]})" for table in missed]
    print(f"\n{len(moved)} cells have moved" + (":" if moved else ""))
    for name, head, before, now, *_ in moved:
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


def make_models(command, bin_dir, folder):
    """Those that the command names, where they are not yet there."""
    for name in filter(MODELS.get, dict.fromkeys(re.findall(r"\b(\w+)\.(?:lode|ply)\b", command))):
        model, store = (pathlib.Path(folder, f"{name}.{ending}") for ending in ("ply", "lode"))
        if store.exists():
            continue
        of_sample, of_build = map(str.split, MODELS[name])
        for made in (["sample", *of_sample, "-o", model], ["build", model, "-o", store, "--quiet", *of_build]):
            subprocess.run([bin_dir / "lodestreamd", *made], check=True, stdout=subprocess.DEVNULL)


def run(command, bin_dir, folder):
    """What it has printed; None if it failed: the others go on."""
    program, *arguments = shlex.split(command)
    start = [sys.executable, HERE / program] if program.endswith(".py") else [bin_dir / program]
    done = subprocess.run([*start, *arguments], cwd=folder, stdout=subprocess.PIPE, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


if __name__ == "__main__":
    main()
