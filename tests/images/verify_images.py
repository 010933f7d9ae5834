#!/usr/bin/python3
"""Builds the images of docker/ and runs them as compose.yaml does, without a Docker engine: buildah builds, crun runs.

usage: verify_images.py [--base FOLDER] [--toolchain FOLDER] [--ccache FOLDER] [--keep]

  --base FOLDER       a root of Debian 13 (debootstrap --variant=minbase trixie FOLDER) to take as debian:trixie-slim, where there is
                      no registry to pull it from
  --toolchain FOLDER  a root that has the packages that compile, to save their installation
  --ccache FOLDER     of objects that were compiled before; the toolchain must have ccache
  --keep              leave the images, and say where they are

Images, volumes and secrets lie in a storage of its own, not in that of the machine. Servers run in network namespaces of their
own, as another user, on a root file system that is read only and without any capability; HAProxy and Prometheus are Debian's,
with the files of docker/. Podman plays the Deployment and the Job of Kubernetes, with their ports on this machine while it does. Needs root
and `docker/install-packages.sh images`; ends with 0 if all that it prints is true, after an hour at most.
"""

import argparse
import contextlib
import json
import os
import re
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

from container import Container, Network, image_size, run, wait_until
from played_pod import PlayedJob, PlayedPod

ROOT = Path(__file__).resolve().parents[2]
DOCKER = ROOT / "docker"
DEBIAN = "localhost/lodestream-debian:trixie-slim"
TOOLCHAIN = "localhost/lodestream-toolchain"
TARGETS = ("builder", "server", "client")
LONGEST_S = 3600
NOT_IN_SLIM = ("doc", "man", "locale", "info")  # of /usr/share


def say(text):
    print(text, flush=True)


def expect(condition, text):
    if not condition:
        sys.exit(f"verify_images: not so: {text}")
    say(f"ok: {text}")


def import_root(folder, image, slim):
    """Makes a base image from a root file system."""
    container = run("buildah", "from", "scratch").stdout.strip()
    mounted = Path(run("buildah", "mount", container).stdout.strip())
    run("tar", "-C", folder, "--one-file-system", "--exclude=./proc/*", "--exclude=./dev/*", "--exclude=./var/cache/apt/*",
        "--exclude=./var/lib/apt/lists/*", *(f"--exclude=./usr/share/{name}/*" for name in NOT_IN_SLIM if slim),
        "-cf", mounted / "root.tar", ".")
    run("tar", "-C", mounted, "-xf", mounted / "root.tar")
    (mounted / "root.tar").unlink()
    run("buildah", "commit", "-q", "--rm", container, image)


def build_images(options):
    arguments = []
    if options.base:
        import_root(options.base, DEBIAN, slim=True)
        arguments += ["--build-arg", f"DEBIAN={DEBIAN}"]
    if options.toolchain:
        import_root(options.toolchain, TOOLCHAIN, slim=False)
        arguments += ["--build-arg", f"TOOLCHAIN={TOOLCHAIN}"]
    if options.ccache:
        sloppiness = "pch_defines,time_macros,include_file_mtime,include_file_ctime"  # as cmake/LodeCcache.cmake has it
        launcher = f"-DCMAKE_CXX_COMPILER_LAUNCHER=env;CCACHE_DIR=/ccache;CCACHE_SLOPPINESS={sloppiness};ccache"
        arguments += ["--volume", f"{options.ccache}:/ccache", "--build-arg", f"CMAKE_OPTIONS={launcher}"]
    for target in TARGETS:
        started = time.monotonic()
        run("buildah", "bud", "--isolation", "chroot", "--pull-never" if options.base else "--pull", "--layers", "--format",
            "docker", "-f", DOCKER / "Dockerfile", "--target", target, "-t", f"lodestream-{target}", *arguments, ROOT)
        say(f"lodestream-{target}: {image_size(f'lodestream-{target}') / 1e6:.0f} MB, built in {time.monotonic() - started:.0f} s")
    if options.base:
        say(f"of which the base has {image_size(DEBIAN) / 1e6:.0f} MB")


def check_files():
    """Checks the files for other programs with these programs or their types."""
    environment = {**os.environ, "SERVER_A": "127.0.0.2", "SERVER_B": "127.0.0.3", "LODESTREAM_MODELS": "/tmp", "GRAFANA_PASSWORD": "a"}
    run("docker-compose", "-f", DOCKER / "compose.yaml", "config", "-q", env=environment)
    del environment["LODESTREAM_MODELS"]
    refused = subprocess.run(["docker-compose", "-f", DOCKER / "compose.yaml", "config", "-q"], env=environment, capture_output=True, text=True)
    expect(refused.returncode != 0 and "name the folder of your stores" in refused.stderr, "compose.yaml asks for the folder of the stores")
    run("haproxy", "-c", "-q", "-f", DOCKER / "haproxy.cfg", env=environment)
    run("promtool", "check", "config", DOCKER / "prometheus" / "prometheus.yml")
    run(Path(__file__).with_name("check_manifests.py"), DOCKER / "kubernetes")
    services = [part for part in yaml.safe_load_all((DOCKER / "kubernetes" / "lodestream.yaml").read_text()) if part["kind"] == "Service"]
    expect(all(service["spec"].get("externalTrafficPolicy") == "Local" for service in services),
           "servers see clients' own addresses on Kubernetes, and so count each client's connections")
    say("ok: compose.yaml, haproxy.cfg, prometheus.yml and the manifests of Kubernetes are what their readers want")


def make_store(folder):
    """Makes a sample and its store with the builder's image, as its user."""
    models, scans = folder / "models", folder / "scans"
    for made in (models, scans):
        made.mkdir()
        os.chown(made, 10001, 10001)
    sample = ["sample", "gyroid", "--triangles", "200000", "-o", "/out/gyroid.ply"]
    build = ["build", "/scans/gyroid.ply", "-o", "/out/gyroid.lode", "--quiet"]
    with Container("lodestream-builder", sample, binds={"/out": scans}, writable=("/out",)) as container:
        expect(container.wait(120) == 0, "the builder's image makes a sample")
    with Container("lodestream-builder", build, binds={"/out": models, "/scans": scans}, writable=("/out",)) as container:
        expect(container.wait(300) == 0, "the builder's image builds a store of it")
    return models


def server_command():
    """Command of the servers in compose.yaml."""
    return yaml.safe_load((DOCKER / "compose.yaml").read_text())["services"]["server-a"]["command"]


def start_server(network, name, models):
    server = Container("lodestream-server", server_command(), network=network.namespace(name), binds={"/models": models})
    wait_until(lambda: server.execute("lodestream-ready") == 0, 20, f"server {name} is not ready")
    return server


def fetch(network, folder):
    """Runs the client's image through HAProxy and returns its output."""
    output = folder / "out.json"
    with Container("lodestream-client", ["fetch", "lode://127.0.0.1:7400/gyroid", "--json", "--cache", "off"],
                   network=network.namespace("hub"), output=output) as client:
        status = client.wait(60)
    return status, output.read_text()


def expect_confined(server):
    status = server.read_proc("status")
    expect(re.search(r"^Uid:\t10001\t10001", status, re.M), "the server is not root")
    expect(re.search(r"^CapEff:\t0+$", status, re.M), "it has no capability")
    expect(server.execute("bash", "-c", ": >/tmp/x || : >/var/tmp/x || : >/models/x") != 0, "it can write nowhere")


def check_metrics(network, folder, addresses):
    """Runs Prometheus with docker/'s file and queries the dashboard's metrics."""
    text = (DOCKER / "prometheus" / "prometheus.yml").read_text()
    for name, address in addresses.items():
        text = text.replace(f"server-{name}", address)
    (folder / "prometheus.yml").write_text(text)
    prometheus = network.start("hub", "prometheus", f"--config.file={folder}/prometheus.yml",
                               f"--storage.tsdb.path={folder}/tsdb", "--web.listen-address=127.0.0.1:9090", "--log.level=error")

    def ask(query):
        answer = network.run("hub", sys.executable, "-c", "import sys, urllib.request, urllib.parse; print(urllib.request.urlopen("
                             "'http://127.0.0.1:9090/api/v1/query?query=' + urllib.parse.quote(sys.argv[1])).read().decode())", query)
        return json.loads(answer.stdout)["data"]["result"] if answer.returncode == 0 else []

    wait_until(lambda: [r["value"][1] for r in ask("up")] == ["1", "1"], 30, "Prometheus does not scrape both servers")
    say("ok: Prometheus scrapes both servers")
    dashboard = json.loads((DOCKER / "grafana" / "lodestream.json").read_text())
    names = {name for panel in dashboard["panels"] for target in panel["targets"]
             for name in re.findall(r"lodestream_\w+", target["expr"])}
    missing = [name for name in sorted(names) if not ask(f'count({{__name__="{name}"}})')]
    expect(not missing, f"the {len(names)} metrics that the dashboard draws are there" + "".join(f", but {m}" for m in missing))
    prometheus.terminate()
    prometheus.wait()


def drain(network, folder, servers, models):
    """Restarts each server in turn while clients connect. No client may fail."""
    fetched = 0
    for name in list(servers):
        servers[name].kill("TERM")
        deadline = time.monotonic() + 20
        while servers[name].poll() is None and time.monotonic() < deadline:
            status, text = fetch(network, folder)
            expect(status == 0 and json.loads(text)["converged"], f"a fetch while server {name} drains")
            fetched += 1
        expect(servers[name].wait(20) == 0, f"server {name} ended with 0")
        status, _ = fetch(network, folder)
        expect(status == 0, f"a fetch without server {name}")
        servers[name].remove()
        servers[name] = start_server(network, name, models)
        time.sleep(1.5)  # HAProxy checks every half second
    expect(fetched >= 2, f"{fetched} fetches while a server drained, none failed")


def play_deployment(folder, models):
    """Plays the Deployment's pod with TLS and a token, and drains it."""
    token = secrets.token_hex(16)
    run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=localhost",
        "-keyout", folder / "tls.key", "-out", folder / "tls.crt")
    secret = {"tokens": f"{token} never *\n", **{name: (folder / name).read_text() for name in ("tls.crt", "tls.key")}}
    (folder / "token").write_text(token)
    (folder / "token").chmod(0o644)

    def fetch_from_pod(*arguments):
        with Container("lodestream-client", ["fetch", "lodes://localhost/gyroid", "--json", "--cache", "off", "--ca-file", "/pod/tls.crt",
                                             *arguments], binds={"/pod": folder, "/etc/hosts": "/etc/hosts"}) as client:
            return client.wait(60)

    with PlayedPod(folder, models, secret) as pod:
        wait_until(pod.ready, 60, "the pod is not ready")
        expect(fetch_from_pod("--token-file", "/pod/token") == 0, "a fetch under TLS from the pod that podman made of the Deployment")
        expect(fetch_from_pod() != 0, "without the token it gives nothing")
        expect(pod.stop(30) == 0, "the pod drains and ends with 0")


def play_job(folder):
    """Plays the Job's pod: the scan is on one volume, the store on the server's."""
    scans, models = (folder / name for name in ("job-scans", "job-models"))
    for made in (scans, models):
        made.mkdir()
    shutil.copy(folder / "scans" / "gyroid.ply", scans / "scan.ply")
    with PlayedJob(folder, scans, models) as job:
        expect(job.wait() == 0, "the pod that podman made of the Job builds a store of the scan and ends with 0")
        shutil.copy(job.store(), models)
    with Container("lodestream-builder", ["verify", "/models/scan.lode"], binds={"/models": models}) as container:
        expect(container.wait(60) == 0, "which is whole")


@contextlib.contextmanager
def storage_of_its_own(keep):
    """Storage of buildah and podman for the `with`, apart from this machine's own."""
    folder = Path(tempfile.mkdtemp(prefix="lodestream-storage-", dir="/var/tmp"))
    settings = folder / "storage.conf"
    settings.write_text(f'[storage]\ndriver = "vfs"\ngraphroot = "{folder}/kept"\nrunroot = "{folder}/running"\n')
    os.environ["CONTAINERS_STORAGE_CONF"] = str(settings)
    try:
        yield
    finally:
        if keep:
            say(f"the images are kept: CONTAINERS_STORAGE_CONF={settings} buildah images")
        else:
            shutil.rmtree(folder)


def in_mounts_of_its_own():
    """Moves into a mount namespace without cgroup 2 if the system has both versions, since crun takes one."""
    if "LODESTREAM_OWN_MOUNTS" not in os.environ:
        os.environ["LODESTREAM_OWN_MOUNTS"] = "yes"
        os.execvp("unshare", ["unshare", "--mount", sys.executable, *sys.argv])
    both = Path("/sys/fs/cgroup/unified")
    if both.is_dir():
        run("umount", both)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--base")
    parser.add_argument("--toolchain")
    parser.add_argument("--ccache")
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args()
    in_mounts_of_its_own()
    for ending in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):  # exit as on SIGINT, so that containers and networks are removed
        signal.signal(ending, lambda number, _: sys.exit(128 + number))
    signal.alarm(LONGEST_S)
    check_files()
    with storage_of_its_own(options.keep):
        build_images(options)
        run_images()
    say("verify_images: all of it is so")


def run_images():
    servers = {}
    with tempfile.TemporaryDirectory(prefix="lodestream-images-") as name, Network(("a", "b")) as network:
        folder = Path(name)
        folder.chmod(0o755)
        try:
            models = make_store(folder)
            servers.update({server: start_server(network, server, models) for server in ("a", "b")})
            expect_confined(servers["a"])
            addresses = {server: network.address(server) for server in servers}
            environment = {"SERVER_A": addresses["a"], "SERVER_B": addresses["b"]}
            network.start("hub", "haproxy", "-db", "-q", "-f", DOCKER / "haproxy.cfg", env={**os.environ, **environment})
            wait_until(lambda: fetch(network, folder)[0] == 0, 20, "no fetch through HAProxy")
            say(f"ok: a fetch through HAProxy: {fetch(network, folder)[1].strip()[:120]}...")
            check_metrics(network, folder, addresses)
            drain(network, folder, servers, models)
        finally:
            for server in servers.values():
                server.remove()
        play_deployment(folder, models)
        play_job(folder)


if __name__ == "__main__":
    main()
