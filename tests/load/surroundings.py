"""Surroundings of a server: a slow disk, a long link. Both need root. They leave nothing behind: after a
kill, the next process removes everything that is named after an ended process.
"""
import contextlib
import os
import pathlib
import subprocess

import control_groups
from control_groups import abandoned
from processes import running


@contextlib.contextmanager
def slow_disk(file, bytes_per_second, memory_bytes):
    """Yields a prefix for commands, which limits the speed of the file's disk and the memory."""
    limited = {1: control_groups.version_1, 2: control_groups.version_2}[control_groups.version()]
    with limited(control_groups.whole_disk(os.stat(file).st_dev), bytes_per_second, memory_bytes) as groups:
        join = "; ".join(f"echo $$ > {group}/cgroup.procs" for group in groups)
        yield ["sh", "-c", f'{join}; exec "$0" "$@"']


def forget(file):
    """Removes a file from the page cache."""
    with open(file, "rb") as opened:
        os.fsync(opened.fileno())
        os.posix_fadvise(opened.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


@contextlib.contextmanager
def long_link(programs, delay_ms=25, mbit_s=10, loss_percent=0, queue_ms=200):
    """Yields two prefixes for commands, which run in two network namespaces with a link between. Servers have the address
    10.9.0.1, clients 10.9.0.2.

    programs: the folder that contains wan. delay_ms: delay in one direction.
"""
    there = subprocess.run(["ip", "netns", "list"], check=True, capture_output=True, text=True).stdout.split()
    for name in abandoned(name for name in there if name.startswith(("lode-near-", "lode-far-"))):
        subprocess.run(["ip", "netns", "del", name], check=True)
    near, far = f"lode-near-{os.getpid()}", f"lode-far-{os.getpid()}"
    for name in (near, far):
        subprocess.run(["ip", "netns", "add", name], check=True)
    try:
        with running([pathlib.Path(programs, "wan"), near, far, delay_ms, mbit_s, loss_percent, queue_ms], stdout=subprocess.PIPE, text=True) as wan:
            wan.stdout.readline()
            for name, address in ((near, "10.9.0.1/24"), (far, "10.9.0.2/24")):
                for command in (["addr", "add", address, "dev", "em0"], ["link", "set", "em0", "up"], ["link", "set", "lo", "up"]):
                    subprocess.run(["ip", "-n", name, *command], check=True)
            yield ["ip", "netns", "exec", near], ["ip", "netns", "exec", far]
    finally:
        for name in (near, far):
            subprocess.run(["ip", "netns", "del", name])


@contextlib.contextmanager
def plain_haproxy(folder, listen, server, prefix=()):
    """Starts HAProxy in front of one server, with its default settings."""
    config = pathlib.Path(folder, "haproxy.cfg")
    config.write_text(f"""
defaults
  mode tcp
  timeout connect 5s
  timeout client 60s
  timeout server 60s
listen lodestream
  bind {listen}
  server one {server}
""")
    with running([*prefix, "haproxy", "-db", "-q", "-f", config]) as process:
        yield process
