"""The Deployment of docker/kubernetes as a pod that podman plays on one machine: with its secret, its volume, its probes and its drain."""

import contextlib
import json
import os
import sys
import urllib.error
import urllib.request
from pathlib import Path

import yaml

from container import run

DEPLOYMENT = Path(__file__).resolve().parents[2] / "docker" / "kubernetes" / "lodestream.yaml"
VOLUME, SECRET = "lodestream-models", "lodestream"

# Podman asks for limits of open files and processes that only a machine's own root may set.
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


class PlayedPod:
    """Runs while the `with` lasts. Its server is at 127.0.0.1:7400, what it says of itself at 127.0.0.1:9400."""

    def __init__(self, folder, models, secret):
        """models: a folder of stores; secret: the texts of the files by their names."""
        runtime, engine = folder / "crun-within-limits", folder / "containers.conf"
        runtime.write_text(RUNTIME.format(python=sys.executable))
        runtime.chmod(0o755)
        engine.write_text(ENGINE.format(runtime=runtime))
        self.environment = {**os.environ, "CONTAINERS_CONF": str(engine)}
        deployment = next(part for part in yaml.safe_load_all(DEPLOYMENT.read_text()) if part["kind"] == "Deployment")
        self.manifest = folder / "deployment.yaml"
        self.manifest.write_text(yaml.safe_dump(deployment))
        self.models, self.secret = models, folder / "secret.json"
        # Podman 4.3 takes a secret's texts as they are, not in base64.
        self.secret.write_text(json.dumps({"apiVersion": "v1", "kind": "Secret", "metadata": {"name": SECRET}, "data": secret}))
        self.container = f"{deployment['metadata']['name']}-pod-0-{deployment['spec']['template']['spec']['containers'][0]['name']}"

    def podman(self, *arguments, check=True):
        return run("podman", *arguments, check=check, env=self.environment).stdout.strip()

    def __enter__(self):
        with contextlib.ExitStack() as failing:
            failing.callback(self.remove)
            self.podman("volume", "create", VOLUME)
            inside = self.podman("volume", "inspect", VOLUME, "--format", "{{.Mountpoint}}")
            run("cp", "-r", f"{self.models}/.", inside)
            self.podman("secret", "create", SECRET, self.secret)
            self.podman("play", "kube", self.manifest)
            failing.pop_all()
        return self

    def __exit__(self, *_):
        self.remove()

    def remove(self):
        self.podman("play", "kube", "--down", self.manifest, check=False)
        self.podman("volume", "rm", "-f", VOLUME, SECRET, check=False)
        self.podman("secret", "rm", SECRET, check=False)

    @staticmethod
    def ready():
        try:
            with urllib.request.urlopen("http://127.0.0.1:9400/readyz", timeout=2) as answer:
                return answer.status == 200
        except (urllib.error.URLError, OSError):
            return False

    def stop(self, seconds):
        """As a scheduler does. Returns the server's exit status."""
        self.podman("stop", "--time", str(seconds), self.container)
        return int(self.podman("inspect", self.container, "--format", "{{.State.ExitCode}}"))
