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

<!-- table: bench, another -->
| model | a node | CPU | memory |
| --- | --- | --- | --- |
| bunny | 512 | 10.0 s | **1,200 MB** |
| bunny | 4,096 | 20.0 s | 300 MB |

<!-- table: other -->
| model | other |
| --- | --- |
| bunny | 7 |
"""


def run(cpu, memory="1,200 MB"):
    return f"| model | a node | CPU | memory |\n| --- | --- | --- | --- |\n| bunny | 512 | {cpu} s | **{memory}** |\n| bunny | 4096 | 20.1 s | 300 MB |\n"


class All(unittest.TestCase):
    def compared(self, *outputs, bench="bench", document=DOCUMENT):
        """None if the document has no such table."""
        (table, cells), = bench_all.merge(outputs)
        known, columns = bench_all.in_document(table, bench, bench_all.tables(document))
        return known and bench_all.compare(table, cells, known, columns)

    def moved(self, *outputs, **more):
        return [(name, head, now) for name, head, _, now, *_ in self.compared(*outputs, **more)]

    def test_names_a_figure_that_is_not_what_the_document_says(self):
        self.assertEqual(self.moved(run(12.0), run(12.4), run(12.1)), [(("bunny", "512"), "CPU", "12.1 s")])

    def test_knows_a_row_by_its_number_however_it_is_written(self):
        self.assertEqual(self.moved(run(10.0).replace("20.1", "30.0")), [(("bunny", "4096"), "CPU", "30.0 s")])

    def test_says_what_tells_another_number_of_figures(self):
        self.assertEqual(self.moved(run("10.0", "none")), [(("bunny", "512"), "memory", "**none**")])

    def test_calls_nothing_moved_that_differs_by_less_than_the_runs_do(self):
        self.assertEqual(self.moved(run(8.0), run(11.0), run(12.4)), [])

    def test_calls_nothing_moved_that_differs_by_less_than_a_twentieth(self):
        self.assertEqual(self.moved(run(10.4), run(10.4), run(10.4)), [])

    def test_leaves_a_figure_as_precise_as_it_was(self):
        self.assertEqual(self.moved(run("10.0", "2,345.67 MB"))[0][2], "**2,346 MB**")

    def test_looks_at_no_table_with_other_heads_or_of_another_bench(self):
        self.assertIsNone(self.compared(run(99.0).replace("CPU", "seconds")))
        self.assertIsNone(self.compared(run(99.0), bench="other"))

    def test_passes_over_columns_that_only_the_document_has(self):
        wider = "\n".join(line.replace("| 10.0 s", "| 12.0 s | 10.0 s").replace("| 20.0 s", "| 22.0 s | 20.0 s").replace("| CPU", "| before | CPU").replace(
            "| --- | --- | --- | --- |", "| --- | --- | --- | --- | --- |") for line in DOCUMENT.splitlines())
        self.assertEqual(self.moved(run(12.0), document=wider), [(("bunny", "512"), "CPU", "12.0 s")])

    def test_writes_what_has_moved_and_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            document = pathlib.Path(folder, "benchmarks.md")
            document.write_text(DOCUMENT)
            with mock.patch.object(bench_all, "DOCUMENT", document):
                bench_all.write(self.compared(run(15.0)))
            self.assertEqual(document.read_text(), DOCUMENT.replace("10.0 s", "15.0 s"))

    def test_has_a_bench_for_each_table_of_the_document_that_is_not_made_by_hand(self):
        document = bench_all.tables(bench_all.DOCUMENT.read_text())
        known = {bench_all.BY_HAND, *bench_all.BENCHES}
        self.assertEqual([table.head for table in document if not table.made_by or not known.issuperset(table.made_by)], [])
        self.assertEqual(set(bench_all.BENCHES).difference(*(table.made_by for table in document)), set())

    def test_goes_on_when_a_bench_fails_and_names_at_the_end_it_and_tables_that_the_document_has_not(self):
        with tempfile.TemporaryDirectory() as folder:
            good, bad = pathlib.Path(folder, "good.py"), pathlib.Path(folder, "bad.py")
            good.write_text("import os, sys\nassert os.path.isabs(sys.argv[1])\nprint('| model | other |\\n| --- | --- |\\n| bunny | 7 |')\n")
            bad.write_text("raise SystemExit(1)\n")
            pathlib.Path(folder, "benchmarks.md").write_text("<!-- table: good -->\n| lost |\n| --- |\n| 7 |\n")
            with mock.patch.object(bench_all, "BENCHES", {"bad": str(bad), "good": f"{good} {{bin}}"}), \
                    mock.patch.object(bench_all, "DOCUMENT", pathlib.Path(folder, "benchmarks.md")), \
                    mock.patch.object(sys, "argv", ["all.py", "bin", "--runs", "1"]), \
                    contextlib.redirect_stdout(io.StringIO()) as told, self.assertRaises(SystemExit) as ended:
                bench_all.main()
        self.assertTrue(str(ended.exception).startswith("all.py: bad, good (its table of lost) failed"), ended.exception)
        self.assertIn("of good (model)", str(ended.exception))
        self.assertIn("| bunny | 7 |", told.getvalue())


if __name__ == "__main__":
    unittest.main()
