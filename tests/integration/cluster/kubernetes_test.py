#!/usr/bin/env python3
"""Tests docker/kubernetes/build-on-cluster.sh and its manifests: kubernetes_test.py BIN

A substitute for kubectl runs the containers' commands with BIN/lodestreamd, as a control plane would: it follows the manifests'
rules of retries, and its volume is a folder. Exits with 77 without python3-yaml.
"""
import filecmp
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import yaml
except ImportError:
    print("skipped: python3-yaml is not installed: docker/install-packages.sh images")
    sys.exit(77)

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "docker" / "kubernetes" / "build-on-cluster.sh"
LABEL = "app.kubernetes.io/name=lodestream-build-on-cluster"
SMALL_NODES = ["--triangles-per-node", "1024", "--quiet"]


class Cluster:
    """State of the substitute between calls: jobs in CLUSTER/jobs, pods in CLUSTER/pods, the volume in CLUSTER/shared."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.jobs, self.shared = self.folder / "jobs", self.folder / "shared"

    def kubectl(self, verb, *arguments):
        status, said = getattr(self, verb)(*arguments)
        print(said, end="")
        return status

    def get(self, what, *arguments):
        if what == "jobs":
            assert arguments == ("-l", LABEL, "-o", "name"), arguments
            return 0, "".join(f"job.batch/{job.name}\n" for job in self.jobs.iterdir())
        assert "Failed" in arguments[1], arguments
        return 0, "True" if (self.jobs / what.removeprefix("job/")).read_text() == "Failed" else ""

    def delete(self, *arguments):
        assert arguments == ("jobs", "-l", LABEL, "--ignore-not-found"), arguments
        for job in self.jobs.iterdir():
            job.unlink()
        return 0, ""

    def wait(self, condition, _, job):
        assert condition == "--for=condition=complete", condition
        return 0 if (self.jobs / job.removeprefix("job/")).read_text() == "Complete" else 1, ""

    def apply(self, *arguments):
        assert arguments[0] == "-l" and arguments[2:] == ("-f", "-"), arguments
        key, _, value = arguments[1].partition("=")
        for job in yaml.safe_load_all(sys.stdin):
            if job["metadata"]["labels"].get(key) == value:
                (self.jobs / job["metadata"]["name"]).write_text(self.run_job(job["spec"]))
        return 0, ""

    def run_job(self, spec):
        indexed = spec.get("completionMode") == "Indexed"
        retries = spec["backoffLimitPerIndex" if indexed else "backoffLimit"]
        indices = range(spec["completions"]) if indexed else [None]
        final = spec["podFailurePolicy"]["rules"][0]
        assert final["action"] == ("FailIndex" if indexed else "FailJob"), final
        done = [self.run_pods(spec["template"]["spec"], index, retries, final["onExitCodes"]["values"]) for index in indices]
        return "Complete" if all(done) else "Failed"

    def run_pods(self, pod, index, retries, final):
        """Runs a pod, and others in its place while they fail. Returns true as soon as one succeeds."""
        container, = pod["containers"]
        mounts = {mount["mountPath"] for mount in container["volumeMounts"]}
        arguments = [word.replace("$(JOB_COMPLETION_INDEX)", str(index)) for word in container["args"]]
        assert container["image"] == "registry.example/builder:1", container["image"]
        assert all(word.split("=")[-1] in mounts for word in arguments if word.startswith("--tmp="))
        for _ in range(retries + 1):
            with (self.folder / "pods").open("a") as pods:
                pods.write(" ".join(arguments) + "\n")
            status = self.run_container(arguments, index)
            if status == 0 or status in final:
                return status == 0
        return False

    def run_container(self, arguments, index):
        fault = self.folder / f"fault-{index}"
        if fault.exists():
            status = int(fault.read_text())
            fault.unlink()
            return status
        return subprocess.run([PROGRAM, *(word.replace("/shared/", f"{self.shared}/") for word in arguments)], check=False,
                              stdout=subprocess.DEVNULL).returncode


class BuildOnCluster(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="lodestream-cluster-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name in ("jobs", "shared", "bin"):
            (self.folder / name).mkdir()
        kubectl = self.folder / "bin" / "kubectl"
        kubectl.write_text(f"#!/bin/sh\nexec {sys.executable} {__file__} {PROGRAM.parent} --cluster {self.folder} \"$@\"\n")
        kubectl.chmod(0o755)
        subprocess.run([PROGRAM, "sample", "asteroid", "--triangles", "20000", "-o", self.folder / "shared" / "site.ply"], check=True,
                       stdout=subprocess.DEVNULL)

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *arguments], env={**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"},
                              capture_output=True, text=True, check=False)

    def build(self):
        return self.run_script("--image", "registry.example/builder:1", "site.ply", "site.lode", "3", *SMALL_NODES)

    def fault(self, index, status):
        (self.folder / f"fault-{index}").write_text(str(status))

    def pods(self):
        return [line for line in (self.folder / "pods").read_text().splitlines()]

    def assert_complete(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)
        plain = self.folder / "plain.lode"
        subprocess.run([PROGRAM, "build", self.folder / "shared" / "site.ply", "-o", plain, *SMALL_NODES], check=True)
        self.assertTrue(filecmp.cmp(self.folder / "shared" / "site.lode", plain, shallow=False))
        self.assertEqual(list((self.folder / "jobs").iterdir()), [])

    def test_gives_the_bytes_of_a_plain_build(self):
        self.assert_complete(self.build())
        self.assertEqual(len(self.pods()), 5)

    def test_replaces_a_pod_that_was_killed(self):
        self.fault(1, 137)
        self.assert_complete(self.build())
        self.assertEqual(len(self.pods()), 6)

    def test_keeps_the_jobs_of_a_failed_build_and_continues_after_they_are_deleted(self):
        self.fault(2, 1)
        self.assertIn("job/lodestream-simplify failed", self.build().stderr)
        self.assertEqual(len(self.pods()), 4)
        self.assertIn("jobs of an earlier build exist: job.batch/lodestream-", self.build().stderr)
        self.assertEqual(self.run_script("--delete").returncode, 0)
        self.assert_complete(self.build())

    def test_refuses_words_that_yaml_could_misread(self):
        result = self.run_script('a".ply', "site.lode", "3")
        self.assertEqual(result.returncode, 2)
        self.assertIn("has characters that this script does not pass on", result.stderr)


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve() / "lodestreamd"
    if sys.argv[1:2] == ["--cluster"]:
        sys.exit(Cluster(sys.argv[2]).kubectl(*sys.argv[3:]))
    unittest.main()
