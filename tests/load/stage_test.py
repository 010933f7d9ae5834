#!/usr/bin/python3
"""Tests of the arithmetic and the cleanup of scenarios, without a server: stage_test.py"""
import contextlib
import errno
import io
import math
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

import control_groups
import ends
import probe
import processes
import scenario
import soak
import stage
import surroundings


class Percentiles(unittest.TestCase):
    def test_are_values_that_occurred(self):
        values = list(range(100, 0, -1))
        self.assertEqual([stage.percentile(values, part) for part in (0.5, 0.99, 1)], [50, 99, 100])
        self.assertEqual(stage.percentile([7], 0.99), 7)

    def test_of_nothing_are_no_numbers(self):
        self.assertTrue(math.isnan(stage.percentile([], 0.5)))


class Metrics(unittest.TestCase):
    TEXT = """# HELP lodestream_connections now
# TYPE lodestream_connections gauge
lodestream_connections 3
lodestream_model_sent_bytes_total{model="a"} 10
lodestream_model_sent_bytes_total{model="b \\"c\\""} 1.5e3
lodestream_request_queue_seconds_bucket{class="visible",le="0.1"} 9
lodestream_request_queue_seconds_count{class="visible"} 4
"""

    def test_are_summed_over_labels(self):
        self.assertEqual(stage.parse_metrics(self.TEXT),
                         dict(connections=3, model_sent_bytes_total=1510, request_queue_seconds_count=4))

    def test_of_a_server_that_began_anew_give_no_negative_rate(self):
        samples = [dict(t=1, n=10), dict(t=2, n=30), dict(t=2.5), dict(t=3, n=5), dict(t=5, n=25)]
        self.assertEqual(stage.rates(samples, "n"), ([2, 5], [20, 10]))
        self.assertEqual(stage.rates([dict(t=1, n=30), dict(t=2, n=5)], "n"), ([2], [0]))

    def test_of_a_server_that_is_away_are_left_out(self):
        class Away:
            def figures(self):
                return None

        class There:
            def figures(self):
                return dict(connections=2)

        with mock.patch.object(stage, "SAMPLE_EVERY_S", 0.001), stage.Sampler([Away(), There(), There()]) as sampler:
            while not sampler.samples:
                time.sleep(0.001)
        self.assertEqual(sampler.most("connections"), 4)
        self.assertEqual(sampler.samples[0]["answering"], 2)


class ProbeTimes(unittest.TestCase):
    def test_of_a_part_of_the_time_are_told(self):
        times = [(0, 1.0), (1, 2.0), (2, 30.0)]
        self.assertEqual(stage.probe_row(times), ("2.0 ms", "30.0 ms", "30.0 ms"))
        self.assertEqual(stage.probe_row(times, until=1), ("1.0 ms",) * 3)
        self.assertEqual(stage.probe_row(times, since=3), ("none",) * 3)

    def test_tell_the_longest_time_without_one(self):
        self.assertEqual(ends.longest_gap([(1, 0), (2, 500), (9, 0)], 10), 6.5)
        self.assertEqual(ends.longest_gap([], 10), 10)
        self.assertEqual(ends.longest_gap([(1, 0)], 10), 9)

    def test_count_each_try_that_failed(self):
        class Flaky:
            tries, closed = 0, 0

            def one(self):
                self.tries += 1
                if self.tries < 3:
                    raise ConnectionResetError

            def close(self):
                self.closed += 1

        flaky = Flaky()
        with mock.patch.object(probe, "RETRY_S", 0):
            self.assertEqual(probe.until_it_comes(flaky, math.inf), (2, True))
            self.assertEqual(flaky.closed, 2)
            self.assertEqual(probe.until_it_comes(flaky, 0), (0, False))


class Processes(unittest.TestCase):
    def test_end_with_who_started_them_however_that_ends(self):
        script = "import processes, time; print(processes.start(['sleep', '60']).pid, flush=True); time.sleep(60)"
        environment = dict(os.environ, PYTHONPATH=str(stage.LOAD))
        with subprocess.Popen([sys.executable, "-c", script], env=environment, stdout=subprocess.PIPE, text=True) as parent:
            pid = int(parent.stdout.readline())
            parent.kill()
        stat, end = pathlib.Path(f"/proc/{pid}/stat"), time.monotonic() + 120
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            while stat.read_text().rsplit(")", 1)[1].split()[0] != "Z":
                self.assertLess(time.monotonic(), end)

    def test_that_are_gone_are_told_from_those_that_are_there(self):
        gone = subprocess.Popen(["true"])
        gone.wait()
        here = [f"lode-bench-{os.getpid()}", pathlib.Path(f"/x/lode-bench-{os.getpid()}")]
        self.assertEqual(control_groups.abandoned([*here, f"lode-bench-{gone.pid}"]), [f"lode-bench-{gone.pid}"])

    def test_that_are_left_behind_are_noticed(self):
        self.assertFalse(scenario.left_behind())
        child = processes.start(["sleep", "60"])
        self.assertTrue(scenario.left_behind())
        stage.Stage.stop(child)
        self.assertFalse(scenario.left_behind())

    def test_of_a_stage_end_with_it_though_it_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(ZeroDivisionError), stage.Stage(folder, folder, store=folder) as failing:
                child = failing.run(["sleep", "60"])
                1 / 0
        self.assertEqual(child.returncode, -signal.SIGKILL)


class FakeControlGroups:
    """Imitates the folders of version 2 and their rules. A group has a controller's files only if its parent enables the
    controller. A group that enables controllers has no processes. A group with processes cannot be removed."""

    def __init__(self, folder, processes, offered="cpu io memory pids", is_the_systems_root=False):
        self.root, self.exempt = pathlib.Path(folder, "groups"), is_the_systems_root
        self.really = {name: getattr(pathlib.Path, name) for name in ("write_text", "mkdir", "rmdir")}
        self.create(self.root)
        self.really["write_text"](self.root / "cgroup.controllers", offered)
        self.put(self.root, processes)

    def __enter__(self):
        self.ending = contextlib.ExitStack()
        for name, own in (("write_text", self.write), ("mkdir", self.create), ("rmdir", self.remove)):
            self.ending.enter_context(mock.patch.object(pathlib.Path, name, lambda path, *given, own=own: own(path, *given)))
        self.ending.enter_context(mock.patch.object(control_groups, "ROOT", self.root))
        return self

    def __exit__(self, *_):
        self.ending.close()

    def words(self, path):
        return path.read_text().split()

    def processes(self, group=""):
        return self.words(self.root / group / "cgroup.procs")

    def put(self, group, processes):
        self.really["write_text"](group / "cgroup.procs", "\n".join(processes))

    def groups(self):
        return [path for path in self.root.iterdir() if path.is_dir()]

    def create(self, group):
        self.really["mkdir"](group)
        for name in ("cgroup.procs", "cgroup.subtree_control"):
            self.really["write_text"](group / name, "")
        if group != self.root and "io" in self.words(self.root / "cgroup.subtree_control"):
            self.really["write_text"](group / "io.max", "")
        if group != self.root and "memory" in self.words(self.root / "cgroup.subtree_control"):
            self.really["write_text"](group / "memory.max", "max")

    def remove(self, group):
        if self.processes(group) or any(path.is_dir() for path in group.iterdir()):
            raise OSError(errno.EBUSY, "busy")
        for path in group.iterdir():
            path.unlink()
        self.really["rmdir"](group)

    def write(self, path, text):
        if not path.exists():
            raise PermissionError(errno.EACCES, "no such file of a control group", str(path))
        group = path.parent
        if path.name == "cgroup.procs":
            if self.words(group / "cgroup.subtree_control") and not self.exempt:
                raise OSError(errno.EBUSY, "hands controllers on")
            for other in (self.root, *self.groups()):
                self.put(other, [process for process in self.processes(other) if process != text])
            return self.put(group, [*self.processes(group), text])
        if path.name == "cgroup.subtree_control":
            there = self.words(path)
            for word in text.split():
                if word[0] == "+" and self.processes(group) and not self.exempt:
                    raise OSError(errno.EBUSY, "has processes")
                there = [name for name in there if name != word[1:]] + [word[1:]] * (word[0] == "+")
            text = " ".join(there)
        self.really["write_text"](path, text)


class ControlGroups(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def expect_limits(self, fake):
        with fake, surroundings.slow_disk(self.folder, 1000, 2000) as prefix:
            group = fake.root / f"lode-bench-{os.getpid()}"
            self.assertIn(f"{group}/cgroup.procs", prefix[2])
            self.assertEqual((group / "memory.max").read_text(), "2000")
            self.assertRegex((group / "io.max").read_text(), r"^\d+:\d+ rbps=1000$")
            self.assertFalse((group / "memory.swap.max").exists())  # as on a system without swap
            (group / "cgroup.procs").write_text("77")
            self.assertEqual(fake.processes(group), ["77"])
            fake.put(group, [])  # the process ends

    def expect_as_before(self, fake, processes, handed_on=()):
        self.assertEqual(fake.groups(), [])
        self.assertEqual(fake.words(fake.root / "cgroup.subtree_control"), list(handed_on))
        self.assertEqual(sorted(fake.processes()), processes)

    def test_of_version_2_are_made_below_the_systems_root(self):
        fake = FakeControlGroups(self.folder, ["1", "2"], is_the_systems_root=True)
        self.expect_limits(fake)
        self.expect_as_before(fake, ["1", "2"])

    def test_of_version_2_leave_what_was_handed_on_before(self):
        fake = FakeControlGroups(self.folder, [])
        (fake.root / "cgroup.subtree_control").write_text("pids memory")
        self.expect_limits(fake)
        self.expect_as_before(fake, [], ["pids", "memory"])

    def test_of_version_2_are_made_in_a_container_whose_processes_make_room(self):
        fake = FakeControlGroups(self.folder, ["1", "2"])
        self.expect_limits(fake)
        self.expect_as_before(fake, ["1", "2"])

    def test_of_version_2_that_a_killed_run_left_are_cleared_up(self):
        gone = subprocess.Popen(["true"])
        gone.wait()
        fake = FakeControlGroups(self.folder, [])
        with fake:
            rest = fake.root / f"lode-rest-{gone.pid}"
            for group in (rest, fake.root / f"lode-bench-{gone.pid}"):
                group.mkdir()
            (rest / "cgroup.procs").write_text("1")
            (fake.root / "cgroup.subtree_control").write_text("+io +memory")
        self.expect_limits(fake)
        self.expect_as_before(fake, ["1"])

    def test_that_cannot_be_had_leave_everything_as_it_was(self):
        fake = FakeControlGroups(self.folder, ["1"])
        really = fake.write

        def refuse(path, text):
            if path.name == "io.max" or (path.name == "cgroup.subtree_control" and refusing_controllers and "+" in text):
                raise OSError(errno.EBUSY, "refused")
            really(path, text)

        for refusing_controllers in (False, True):
            with self.subTest(refusing_controllers=refusing_controllers), mock.patch.object(fake, "write", refuse), fake:
                with self.assertRaises(OSError), surroundings.slow_disk(self.folder, 1000, 2000):
                    self.fail("it cannot be had")
                self.expect_as_before(fake, ["1"])

    def test_are_of_version_1_where_there_are_both_and_of_none_without_the_controllers(self):
        fake = FakeControlGroups(self.folder, [], offered="hugetlb")
        with mock.patch.object(control_groups, "ROOT", fake.root):
            self.assertIsNone(control_groups.version())
            (fake.root / "cgroup.controllers").write_text("memory io")
            self.assertEqual(control_groups.version(), 2)
            for kind in ("blkio", "memory"):
                fake.really["mkdir"](fake.root / kind)
            self.assertEqual(control_groups.version(), 1)

    def test_of_the_systems_version_2_make_room_and_put_back(self):
        """Uses a harmless controller, in a separate group, with the system's real rules."""
        above = pathlib.Path("/sys/fs/cgroup/unified")
        if os.geteuid() != 0 or not (above / "cgroup.controllers").is_file() or "hugetlb" not in (above / "cgroup.controllers").read_text():
            self.skipTest("needs root and, beside control groups of version 1, version 2 with hugetlb")
        container = above / f"lode-test-{os.getpid()}"
        was = (above / "cgroup.subtree_control").read_text()
        (above / "cgroup.subtree_control").write_text("+hugetlb")
        self.addCleanup(lambda: "hugetlb" in was or (above / "cgroup.subtree_control").write_text("-hugetlb"))
        container.mkdir()
        self.addCleanup(container.rmdir)
        sleeper = processes.start(["sleep", "60"])
        self.addCleanup(stage.Stage.stop, sleeper)
        (container / "cgroup.procs").write_text(str(sleeper.pid))
        with mock.patch.object(control_groups, "ROOT", container), mock.patch.object(control_groups, "CONTROLLERS", ("hugetlb",)):
            group = container / f"lode-bench-{os.getpid()}"
            with control_groups.controllers_below_the_root(), control_groups.made([group]):
                self.assertEqual((container / "cgroup.procs").read_text(), "")
                self.assertTrue(list(group.glob("hugetlb.*")))
            self.assertEqual((container / "cgroup.procs").read_text().split(), [str(sleeper.pid)])
            self.assertEqual([path for path in container.iterdir() if path.is_dir()], [])


class Scenarios(unittest.TestCase):
    def test_are_all_told_of_by_help(self):
        self.assertEqual([name for name in scenario.SCENARIOS if f"\n{name} " not in scenario.__doc__], [])

    def test_end_when_their_time_is_over(self):
        with self.assertRaises(SystemExit) as said, mock.patch.object(signal, "signal"):
            scenario.end(signal.SIGALRM, None)
        self.assertIn("in time", str(said.exception))

    def test_that_are_interrupted_say_so_in_a_line_and_leave_nothing(self):
        """Uses programs and a client that only wait."""
        with tempfile.TemporaryDirectory() as name:
            folder, temporary = pathlib.Path(name), pathlib.Path(name, "temporary")
            temporary.mkdir()
            programs = {"lodestreamd": f'case $1 in info) echo \'{{"payloads": 9}}\';; serve) echo ready; exec sleep 60;; esac',
                        "lodestream": "touch crowd; exec sleep 60"}
            for program, script in programs.items():
                (folder / program).write_text(f"#!/bin/sh\n{script}\n")
                (folder / program).chmod(0o755)
            (folder / scenario.MESSAGES).write_text("import pathlib, time\npathlib.Path('probe').touch()\ntime.sleep(60)\n")
            begun = [folder / "crowd", folder / "probe"]
            for number in (signal.SIGINT, signal.SIGTERM):
                with self.subTest(number):
                    for file in begun:
                        file.unlink(missing_ok=True)
                    with subprocess.Popen([sys.executable, stage.LOAD / "scenario.py", "steady", folder, "--messages", folder], text=True, cwd=folder,
                                          env=dict(os.environ, TMPDIR=str(temporary)), stderr=subprocess.PIPE, start_new_session=True) as playing:
                        processes.eventually(lambda: all(file.exists() for file in begun))
                        os.killpg(playing.pid, number)  # signals the whole process group, as a terminal does
                        said = playing.communicate(timeout=120)[1]
                    self.assertEqual((playing.returncode, said.count("\n"), said.split(":")[0]), (128 + number, 1, "ended by a signal"))
                    self.assertEqual(list(temporary.iterdir()), [])

    def test_say_what_they_lack(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            lacking = lambda of: scenario.missing(of, folder, folder)
            for file in ("lodestreamd", "lodestream"):
                self.assertIn(str(folder / file), lacking(ends.restart))
                (folder / file).touch()
            self.assertIn(scenario.MESSAGES, lacking(ends.restart))
            (folder / scenario.MESSAGES).touch()
            with mock.patch.object(scenario.shutil, "which", return_value=None):
                self.assertIn("haproxy", lacking(ends.rolling_upgrade))
                self.assertIn("openssl", lacking(scenario.soak.soak))
                self.assertIsNone(lacking(ends.restart))
            with mock.patch.object(scenario.shutil, "which", return_value="there"), mock.patch.object(scenario.os, "geteuid", return_value=1):
                self.assertIn("root", lacking(scenario.links.lossy))
            with mock.patch.object(scenario.shutil, "which", return_value="there"), mock.patch.object(scenario.os, "geteuid", return_value=0):
                self.assertIn("wan", lacking(scenario.links.lossy))
                with mock.patch.object(control_groups, "ROOT", folder / "none"):
                    self.assertIn("control groups", lacking(scenario.links.larger_than_memory))
                with mock.patch.object(control_groups, "version", return_value=2), mock.patch.object(scenario.os, "major", return_value=0):
                    self.assertIn("TMPDIR", lacking(scenario.links.larger_than_memory))


class Growth(unittest.TestCase):
    LULLS = 30

    def run_that(self, leaks=0, wavers=0, chance=random.Random(1)):
        """Returns simulated values in the lulls of half an hour."""
        return [20e6 + leaks * number / self.LULLS + chance.gauss(0, wavers) for number in range(self.LULLS)]

    def test_of_what_leaks_is_told(self):
        for leak in (0.5e6, 20e6, 300e6):
            self.assertTrue(soak.grows(self.run_that(leak), soak.LEAST_ALLOCATED), leak)
        self.assertTrue(soak.grows(self.run_that(leaks=4, wavers=0.5), soak.LEAST_DESCRIPTORS))

    def test_of_what_leaks_is_told_though_what_is_held_wavers(self):
        told = [soak.grows(self.run_that(leaks=0.64e6, wavers=0.1e6), soak.LEAST_ALLOCATED) for _ in range(200)]
        self.assertGreater(sum(told), 190)

    def test_at_the_end_of_a_run_is_told(self):
        calm = self.run_that(wavers=0.1e6)
        self.assertTrue(soak.grows(calm[:-7] + [6e6 + value for value in calm[-7:]], soak.LEAST_ALLOCATED))

    def test_in_the_first_quarter_is_warming_up(self):
        warming = self.run_that()
        warming[:7] = [4e6 + 2e6 * number for number in range(7)]
        self.assertFalse(soak.grows(warming, soak.LEAST_ALLOCATED))

    def test_of_little_is_none(self):
        self.assertFalse(soak.grows(self.run_that(leaks=0.25e6), soak.LEAST_ALLOCATED))

    def test_by_chance_is_none(self):
        told = [soak.grows(self.run_that(wavers=1e6), soak.LEAST_ALLOCATED) for _ in range(1000)]
        self.assertLess(sum(told), 10)

    def test_is_of_lulls_alone(self):
        watch = soak.Watch(None)
        watch.seconds, watch.lulls = list(range(10)), [(2, 4), (7, 8)]
        self.assertEqual(watch.in_lulls([9, 9, 5, 3, 4, 1, 0, 8, 6, 2]), [3, 6])


class Figures(unittest.TestCase):
    def test_are_printed_and_drawn_as_they_are_given(self):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            stage.print_table(("a", "b"), [(1, "two")])
        self.assertEqual(said.getvalue(), "| a | b |\n| --- | --- |\n| 1 | two |\n")
        plot = stage.Plot("title")
        plot.panel("ms", ("one", (0, 1), (2, 30)), ("other", (), ()), log=True)
        plot.panel("alone: ms", ("", (0, 1), (0, 0.2)), log=True)
        self.assertEqual(plot.decades(), (0.1, 100))
        self.drawn(plot.write)

    def test_are_drawn_of_a_scenario_that_fails_too(self):
        def failing(played_on):
            played_on.plot = stage.Plot("title")
            played_on.plot.panel("ms", ("", (0, 1), (2, 30)))
            raise AssertionError("not everybody was served")

        def play(path):
            with self.assertRaises(AssertionError):
                scenario.play(failing, mock.Mock(plot=None), path)

        self.drawn(play)

    def drawn(self, write):
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stderr(io.StringIO()) as said:
            path = pathlib.Path(folder, "plot.svg")
            write(path)
            self.assertTrue("python3-matplotlib" in said.getvalue() or "<svg" in path.read_text())


if __name__ == "__main__":
    unittest.main()
