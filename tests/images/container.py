"""Containers by buildah and crun, and network namespaces for them, in place of an engine."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def run(*command, check=True, **options):
    """Runs a command and prints its output if it fails."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if check and result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {result.returncode}\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
    return result


def wait_until(condition, seconds, complaint):
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            sys.exit(f"after {seconds} s: {complaint}")
        time.sleep(0.1)


def image_size(image):
    """Total size of the files in bytes."""
    container = run("buildah", "from", "--pull-never", image).stdout.strip()
    mounted = run("buildah", "mount", container).stdout.strip()
    size = int(run("du", "-sb", "--one-file-system", mounted).stdout.split()[0])
    run("buildah", "rm", container)
    return size


class Network:
    """A network namespace "hub" and other namespaces, each linked to the hub. Programs in the hub reach all
    of them."""

    def __init__(self, names):
        self.prefix = f"lode{os.getpid()}"
        self.names = {name: f"10.77.{number}.2" for number, name in enumerate(names, 1)}
        self.processes = []

    def __enter__(self):
        with contextlib.ExitStack() as failing:
            failing.callback(self.__exit__)
            self.set_up()
            failing.pop_all()
        return self

    def set_up(self):
        run("ip", "netns", "add", self.namespace("hub", path=False))
        self.run("hub", "ip", "link", "set", "lo", "up", check=True)
        for number, (name, address) in enumerate(self.names.items(), 1):
            inner, hub = self.namespace(name, path=False), self.namespace("hub", path=False)
            run("ip", "netns", "add", inner)
            run("ip", "link", "add", f"to-{name}", "netns", hub, "type", "veth", "peer", "name", "eth0", "netns", inner)
            for space, device, own in (("hub", f"to-{name}", f"10.77.{number}.1"), (name, "eth0", address)):
                self.run(space, "ip", "address", "add", f"{own}/24", "dev", device, check=True)
                self.run(space, "ip", "link", "set", device, "up", check=True)
            self.run(name, "ip", "link", "set", "lo", "up", check=True)

    def __exit__(self, *_):
        for process in self.processes:
            process.kill()
            process.wait()
        for name in ("hub", *self.names):
            run("ip", "netns", "delete", self.namespace(name, path=False), check=False)

    def namespace(self, name, path=True):
        return f"{'/run/netns/' if path else ''}{self.prefix}-{name}"

    def address(self, name):
        return self.names[name]

    def run(self, name, *command, check=False):
        return run("ip", "netns", "exec", self.namespace(name, path=False), *command, check=check)

    def start(self, name, *command, **options):
        """Runs a program in the background until the network ends."""
        self.processes.append(subprocess.Popen(
            ["ip", "netns", "exec", self.namespace(name, path=False), *map(str, command)],
            stdout=subprocess.DEVNULL, **options))
        return self.processes[-1]


class Container:
    """A process in an image, as the image's user, on a read-only root, without capabilities."""

    def __init__(self, image, arguments, network=None, binds=None, writable=(), output=None):
        self.bundle = Path(tempfile.mkdtemp(prefix="lodestream-container-"))
        self.name = self.bundle.name
        self.container = run("buildah", "from", "--pull-never", image).stdout.strip()
        mounted = run("buildah", "mount", self.container).stdout.strip()
        config = json.loads(run("buildah", "inspect", "--type", "image", image).stdout)["Docker"]["config"]
        (self.bundle / "config.json").write_text(json.dumps(
            self.describe(config, mounted, arguments, network, binds or {}, writable)))
        self.output = open(output or os.devnull, "w", encoding="utf-8")
        self.errors = open(self.bundle / "stderr", "w", encoding="utf-8")
        self.process = subprocess.Popen(
            ["crun", "--cgroup-manager=disabled", "run", "--bundle", self.bundle, self.name],
            stdin=subprocess.DEVNULL, stdout=self.output, stderr=self.errors)

    @staticmethod
    def describe(config, root, arguments, network, binds, writable):
        """config.json of the OCI runtime specification, for crun."""
        user, group = (int(number) for number in config["User"].split(":"))
        namespaces = [{"type": kind} for kind in ("pid", "ipc", "uts", "mount")]
        if network:
            namespaces.append({"type": "network", "path": network})
        mounts = [
            {"destination": "/proc", "type": "proc", "source": "proc"},
            {"destination": "/dev", "type": "tmpfs", "source": "tmpfs", "options": ["nosuid", "mode=755", "size=64k"]},
        ]
        mounts += [{"destination": inside, "type": "bind", "source": str(outside),
                    "options": ["bind", "rw" if inside in writable else "ro"]} for inside, outside in binds.items()]
        return {
            "ociVersion": "1.0.0",
            "root": {"path": root, "readonly": True},
            "process": {"user": {"uid": user, "gid": group}, "args": [*config["Entrypoint"], *arguments],
                        "env": config["Env"], "cwd": config.get("WorkingDir") or "/", "capabilities": {},
                        "noNewPrivileges": True},
            "mounts": mounts,
            "linux": {"namespaces": namespaces},
        }

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.remove()

    def poll(self):
        return self.process.poll()

    def wait(self, seconds):
        """Exit status; prints stderr if it is not 0."""
        status = self.process.wait(seconds)
        if status != 0:
            print((self.bundle / "stderr").read_text()[-2000:], file=sys.stderr)
        return status

    def kill(self, name):
        run("crun", "kill", self.name, name)

    def execute(self, *command):
        """Runs a command beside the process and returns its exit status."""
        return run("crun", "--cgroup-manager=disabled", "exec", self.name, *command, check=False).returncode

    def read_proc(self, file):
        process = json.loads(run("crun", "state", self.name).stdout)["pid"]
        return Path(f"/proc/{process}/{file}").read_text()

    def remove(self):
        if self.process.poll() is None:
            run("crun", "kill", self.name, "KILL", check=False)
            self.process.wait(10)
        self.output.close()
        self.errors.close()
        run("crun", "delete", "-f", self.name, check=False)
        run("buildah", "rm", self.container, check=False)
        shutil.rmtree(self.bundle, ignore_errors=True)
