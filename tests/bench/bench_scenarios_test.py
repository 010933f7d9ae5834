#!/usr/bin/env python3
"""How bench_scenarios.py ends."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(BENCH.parent / "load"))
from processes import eventually  # noqa: E402

SCENARIO = """
import pathlib, signal, sys, time

def end(*_):
    time.sleep(1)  # as one that ends servers
    pathlib.Path("cleared").touch()
    sys.exit(130)

signal.signal(signal.SIGINT, end)
print("begun", flush=True)
pathlib.Path("begun").touch()
time.sleep(60)
"""
BENCHMARK = "import pathlib, bench_scenarios; bench_scenarios.SCENARIO = pathlib.Path('scenario.py').resolve(); bench_scenarios.main()"


class Interrupted(unittest.TestCase):
    def test_waits_until_the_scenario_has_cleared_its_stage(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scenario = folder / "scenario.py"
            scenario.write_text(f"#!{sys.executable}\n{SCENARIO}")
            scenario.chmod(0o755)
            with subprocess.Popen([sys.executable, "-c", BENCHMARK, ".", "steady"], cwd=folder, env=dict(os.environ, PYTHONPATH=str(BENCH)),
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True) as running:
                running.stdout.readline()
                eventually(lambda: (folder / "begun").exists() or running.poll() is not None)
                os.killpg(running.pid, signal.SIGINT)  # as a terminal does, to all that are of its group
                _, said = running.communicate(timeout=60)
            self.assertEqual((running.returncode, said, (folder / "cleared").exists()), (130, "", True))


if __name__ == "__main__":
    unittest.main()
