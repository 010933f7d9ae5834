"""The Deployment and the Job of docker/kubernetes as pods that podman plays on one machine, with secret and volumes, probes and
drain."""

import contextlib
import json
import os
import sys
import urllib.error
import urllib.request
from pathlib import Path

import yaml

from container import run

MANIFESTS = Path(__file__).resolve().parents[2] / "docker" / "kubernetes"
MODELS, SCANS, SECRET = "lodestream-models", "lodestream-scans", "lodestream"

# Removes podman's limits of open files and processes, which only the root user of the machine may set.
RUNTIME = """#!{python}
import json, os, sys
if "create" in sys.argv:
    path = os.path.join(sys.argv[sys.argv.index("--bundle") + 1], "config.json")
    with open(path) as file:
        config = json.load(file)
    config["process"].pop("rlimits", None)
    with open(path, "w") as file:
        json.dump(config, file)
os.execvp("crun", ["crun", *sys.argv[1:]])
"""
ENGINE = """[engine]
cgroup_manager = "cgroupfs"
events_logger = "file"
runtime = "limited"
[engine.runtimes]
limited = ["{runtime}"]
"""


class Played:
    """A pod that podman runs until the end of the `with` block."""

    def __init__(self, folder, played, container, volumes):
        """played: an object that podman knows. volumes: folders by the names of their claims."""
        runtime, engine = folder / "crun-within-limits", folder / "containers.conf"
        runtime.write_text(RUNTIME.format(python=sys.executable))
        runtime.chmod(0o755)
        engine.write_text(ENGINE.format(runtime=runtime))
        self.environment = {**os.environ, "CONTAINERS_CONF": str(engine)}
        self.manifest = folder / f"{played['metadata']['name']}.yaml"
        self.manifest.write_text(yaml.safe_dump(played))
        self.container, self.volumes = container, volumes

    def podman(self, *arguments, check=True):
        return run("podman", *arguments, check=check, env=self.environment).stdout.strip()

    def files(self, volume):
        return Path(self.podman("volume", "inspect", volume, "--format", "{{.Mountpoint}}"))

    def __enter__(self):
        with contextlib.ExitStack() as failing:
            failing.callback(self.remove)
            for volume, folder in self.volumes.items():
                self.podman("volume", "create", "--opt", "o=uid=10001,gid=10001", volume)  # a kubelet does this by fsGroup
                run("cp", "-r", f"{folder}/.", self.files(volume))
            self.before()
            self.podman("play", "kube", self.manifest)
            failing.pop_all()
        return self

    def before(self):
        pass

    def __exit__(self, *_):
        self.remove()

    def remove(self):
        self.podman("play", "kube", "--down", self.manifest, check=False)
        for volume in self.volumes:
            self.podman("volume", "rm", "-f", volume, check=False)


class PlayedJob(Played):
    """The pod of the Job, because podman 4.3 does not support jobs."""

    def __init__(self, folder, scans, models):
        """Folders of the scan and of its store."""
        job = yaml.safe_load((MANIFESTS / "build-store.yaml").read_text())
        name, template = job["metadata"]["name"], job["spec"]["template"]
        pod = {"apiVersion": "v1", "kind": "Pod", "metadata": {**template["metadata"], "name": name}, "spec": template["spec"]}
        super().__init__(folder, pod, f"{name}-{template['spec']['containers'][0]['name']}", {SCANS: scans, MODELS: models})

    def wait(self):
        """Returns the build's exit status."""
        return int(self.podman("wait", self.container))

    def store(self):
        return self.files(MODELS) / "scan.lode"


class PlayedPod(Played):
    """The Deployment, with its server at 127.0.0.1:7400 and its metrics at 127.0.0.1:9400."""

    def __init__(self, folder, models, secret):
        """models: a folder of stores; secret: contents of files by name."""
        deployment = next(part for part in yaml.safe_load_all((MANIFESTS / "lodestream.yaml").read_text()) if part["kind"] == "Deployment")
        name = deployment["metadata"]["name"]
        super().__init__(folder, deployment, f"{name}-pod-0-{deployment['spec']['template']['spec']['containers'][0]['name']}", {MODELS: models})
        # Podman 4.3 reads a secret's values as plain text, not as base64.
        self.secret = folder / "secret.json"
        self.secret.write_text(json.dumps({"apiVersion": "v1", "kind": "Secret", "metadata": {"name": SECRET}, "data": secret}))

    def before(self):
        self.podman("secret", "create", SECRET, self.secret)

    def remove(self):
        super().remove()
        self.podman("volume", "rm", "-f", SECRET, check=False)
        self.podman("secret", "rm", SECRET, check=False)

    @staticmethod
    def ready():
        try:
            with urllib.request.urlopen("http://127.0.0.1:9400/readyz", timeout=2) as answer:
                return answer.status == 200
        except (urllib.error.URLError, OSError):
            return False

    def stop(self, seconds):
        """Stops the pod as a scheduler does. Returns the server's exit status."""
        self.podman("stop", "--time", str(seconds), self.container)
        return int(self.podman("inspect", self.container, "--format", "{{.State.ExitCode}}"))
