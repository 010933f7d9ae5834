#!/usr/bin/env python3
"""What all.py makes of the benches' tables and of the document's."""
import contextlib
import importlib.util
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

spec = importlib.util.spec_from_file_location("bench_all", pathlib.Path(__file__).with_name("all.py"))
bench_all = importlib.util.module_from_spec(spec)
spec.loader.exec_module(bench_all)

DOCUMENT = """Text | with a bar.

| model | a node | CPU | memory |
| --- | --- | --- | --- |
| bunny | 512 | 10.0 s | **1,200 MB** |
| bunny | 4,096 | 20.0 s | 300 MB |

| model | other |
| --- | --- |
| bunny | 7 |
"""


def run(cpu, memory="1,200 MB"):
    return f"| model | a node | CPU | memory |\n| --- | --- | --- | --- |\n| bunny | 512 | {cpu} s | **{memory}** |\n| bunny | 4096 | 20.1 s | 300 MB |\n"


class All(unittest.TestCase):
    def compared(self, *outputs):
        (table, cells), = bench_all.merge(outputs)
        return bench_all.compare(table, cells, bench_all.tables(DOCUMENT))

    def moved(self, *outputs):
        return [(name, head, now) for name, head, _, now, _ in self.compared(*outputs)]

    def test_names_a_figure_that_is_not_what_the_document_says(self):
        self.assertEqual(self.moved(run(12.0), run(12.4), run(12.1)), [(("bunny", "512"), "CPU", "12.1 s")])

    def test_knows_a_row_by_its_number_however_it_is_written(self):
        self.assertEqual(self.moved(run(10.0).replace("20.1", "30.0")), [(("bunny", "4096"), "CPU", "30.0 s")])

    def test_calls_nothing_moved_that_differs_by_less_than_the_runs_do(self):
        self.assertEqual(self.moved(run(8.0), run(11.0), run(12.4)), [])

    def test_calls_nothing_moved_that_differs_by_less_than_a_twentieth(self):
        self.assertEqual(self.moved(run(10.4), run(10.4), run(10.4)), [])

    def test_leaves_a_figure_as_precise_as_it_was(self):
        self.assertEqual(self.moved(run("10.0", "2,345.67 MB"))[0][2], "**2,346 MB**")

    def test_looks_at_no_table_with_other_heads(self):
        other = run(99.0).replace("CPU", "seconds")
        self.assertIsNone(self.compared(other))

    def test_writes_what_has_moved_and_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            bench_all.DOCUMENT = pathlib.Path(folder, "benchmarks.md")
            bench_all.DOCUMENT.write_text(DOCUMENT)
            (table, cells), = bench_all.merge([run(15.0)])
            bench_all.write(bench_all.compare(table, cells, bench_all.tables(DOCUMENT)))
            self.assertEqual(bench_all.DOCUMENT.read_text(), DOCUMENT.replace("10.0 s", "15.0 s"))

    def test_goes_on_when_a_bench_fails_and_names_at_the_end_it_and_tables_that_the_document_has_not(self):
        with tempfile.TemporaryDirectory() as folder:
            good, bad = pathlib.Path(folder, "good.py"), pathlib.Path(folder, "bad.py")
            good.write_text("import os, sys\nassert os.path.isabs(sys.argv[1])\nprint('| model | other |\\n| --- | --- |\\n| bunny | 7 |')\n")
            bad.write_text("raise SystemExit(1)\n")
            pathlib.Path(folder, "benchmarks.md").write_text("no table")
            with mock.patch.object(bench_all, "BENCHES", {"bad": str(bad), "good": f"{good} {{bin}}"}), \
                    mock.patch.object(bench_all, "DOCUMENT", pathlib.Path(folder, "benchmarks.md")), \
                    mock.patch.object(sys, "argv", ["all.py", "bin", "--runs", "1"]), \
                    contextlib.redirect_stdout(io.StringIO()) as told, self.assertRaises(SystemExit) as ended:
                bench_all.main()
        self.assertTrue(str(ended.exception).startswith("all.py: bad failed"), ended.exception)
        self.assertIn("of good (model)", str(ended.exception))
        self.assertIn("| bunny | 7 |", told.getvalue())


if __name__ == "__main__":
    unittest.main()
