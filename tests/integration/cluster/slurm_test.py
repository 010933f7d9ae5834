#!/usr/bin/env python3
"""Tests of builds on a cluster: slurm_test.py BIN

BIN has the programs. Slurm runs on this machine (docker/slurm/one-machine.sh). Tests of Slurm and of GNU parallel are skipped
where these are not installed; if both are missing, the script exits with 77.
"""
import filecmp
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

SLURM = pathlib.Path(__file__).resolve().parents[3] / "docker" / "slurm"
SKIPPED = 77
TASKS = 6
SMALL_NODES = ["--triangles-per-node", "1024", "--quiet"]
PATIENCE_S = 120

# Runs lodestreamd, but first takes a fault of its task, if there is one: each fault strikes once.
FAULTY = """#!/usr/bin/env bash
task=none
for ((i = 1; i < $#; i++)); do
  if [[ "${{!i}}" == --task ]]; then next=$((i + 1)); task="${{!next}}"; fi
done
echo "$task ${{SLURMD_NODENAME:-}}" >>{folder}/runs
for fault in {folder}/"$task".*; do
  rm "$fault" 2>/dev/null || continue
  case "$fault" in
    *.abort) kill -ABRT $$ ;;
    *.temporary) exit 75 ;;
    *.final) exit 1 ;;
    *.stop)
      {program} "$@" &
      kill -STOP $!
      echo "$SLURMD_NODENAME" >{folder}/stopping && mv {folder}/stopping {folder}/stopped
      wait
      ;;
  esac
done
exec {program} "$@"
"""


def installed(*tools):
    return all(shutil.which(tool) for tool in tools)


def wait_until(condition, complaint):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"not so after {PATIENCE_S} s: {complaint}")
        time.sleep(0.1)


class Build(unittest.TestCase):
    """Makes a sample and the store of a plain build of it."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="lodestream-cluster-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.input, cls.plain = cls.folder / "sample.ply", cls.folder / "plain.lode"
        subprocess.run([PROGRAM, "sample", "asteroid", "--triangles", "100000", "-o", cls.input], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAM, "build", cls.input, "-o", cls.plain, *SMALL_NODES], check=True)

    def setUp(self):
        self.faults = self.folder / self._testMethodName
        self.faults.mkdir()
        self.output = self.faults / "out.lode"
        self.program = self.faults / "lodestreamd"
        self.program.write_text(FAULTY.format(folder=self.faults, program=PROGRAM))
        self.program.chmod(0o755)

    def fault(self, task, *kinds):
        """Lets the first runs of a task fail."""
        for number, kind in enumerate(kinds):
            (self.faults / f"{task}.{number}.{kind}").touch()

    def nodes_of_runs(self, task):
        lines = [line.split(" ") for line in (self.faults / "runs").read_text().splitlines()]
        return [node for ran, node in lines if ran == str(task)]

    def assert_complete(self):
        self.assertTrue(filecmp.cmp(self.output, self.plain, shallow=False), "the bytes differ from those of a plain build")
        self.assertFalse((self.faults / ".out.lode.building").exists())


@unittest.skipUnless(installed("slurmctld", "slurmd", "munged"), "Slurm is not installed: docker/install-packages.sh cluster")
class OnSlurm(Build):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cluster = cls.folder / "slurm"
        cls.one_machine("--nodes", "4", "start", cls.cluster)
        cls.addClassCleanup(cls.one_machine, "stop", cls.cluster)

    @staticmethod
    def one_machine(*arguments):
        subprocess.run([SLURM / "one-machine.sh", *arguments], check=True, stdout=subprocess.DEVNULL)

    def start_build(self):
        command = [SLURM / "build.sh", "--cpus", "1", "--mem", "1G", "--program", self.program, "--wait", self.input, self.output, str(TASKS)]
        build = subprocess.Popen(command + SMALL_NODES, env={**os.environ, "SLURM_CONF": str(self.cluster / "slurm.conf")},
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(build.wait)
        self.addCleanup(build.kill)
        return build

    def finish_build(self, build, status):
        said, _ = build.communicate(timeout=PATIENCE_S)
        logs = "".join(f"{log.name}: {log.read_text()}" for log in sorted(pathlib.Path(f"{self.output}.log").iterdir()))
        self.assertEqual(build.returncode, status, said + logs)
        return said

    def test_gives_the_same_bytes_although_tasks_fail_and_a_node_dies(self):
        self.fault(1, "abort")
        self.fault(2, "temporary", "temporary")
        self.fault(3, "stop")
        build = self.start_build()
        wait_until((self.faults / "stopped").exists, "task 3 runs")
        dead = (self.faults / "stopped").read_text().strip()
        self.one_machine("kill-node", self.cluster, dead)
        self.assertIn("complete: ", self.finish_build(build, status=0))
        self.assert_complete()
        self.assertEqual(len(self.nodes_of_runs(1)), 2)
        self.assertEqual(len(self.nodes_of_runs(2)), 3)
        self.assertEqual(self.nodes_of_runs(3)[0], dead)
        self.assertEqual(len(self.nodes_of_runs(3)), 2)
        self.assertNotEqual(self.nodes_of_runs(3)[1], dead)

    def test_does_not_retry_a_task_that_no_retry_cures_and_goes_on_with_the_same_command(self):
        self.fault(1, "final")
        self.assertIn("is CANCELLED; read ", self.finish_build(self.start_build(), status=1))
        self.assertEqual(len(self.nodes_of_runs(1)), 1)
        self.assertFalse(self.output.exists())
        self.finish_build(self.start_build(), status=0)
        self.assert_complete()


@unittest.skipUnless(installed("parallel"), "GNU parallel is not installed: docker/install-packages.sh cluster")
class UnderGnuParallel(Build):
    def part(self, *arguments):
        return [self.program, "build", self.input, "-o", self.output, *SMALL_NODES, "--tasks", str(TASKS), "--part", *arguments]

    def test_gives_the_same_bytes_although_a_task_aborts(self):
        self.fault(4, "abort")
        subprocess.run(self.part("prepare"), check=True)
        tasks = [str(task) for task in (3, 0, 5, 4, 1, 2)]
        subprocess.run(["parallel", "--will-cite", "--jobs", "2", "--retries", "3", *self.part("simplify", "--task", "{}"), ":::", *tasks],
                       check=True, stderr=subprocess.DEVNULL)
        subprocess.run(self.part("finish"), check=True)
        self.assert_complete()
        self.assertEqual(len(self.nodes_of_runs(4)), 2)


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve() / "lodestreamd"
    if not installed("slurmctld") and not installed("parallel"):
        print("skipped: neither Slurm nor GNU parallel is installed: docker/install-packages.sh cluster")
        sys.exit(SKIPPED)
    unittest.main()
