"""Control groups of version 1 or 2 that limit the memory and the disk of a command. They need root. The name of a group ends
with the id of the process that made it. If that process has ended, the next process removes the group.
"""
import contextlib
import errno
import os
import pathlib

ROOT = pathlib.Path("/sys/fs/cgroup")
NAME, REST = "lode-bench", "lode-rest"
CONTROLLERS = ("memory", "io")


def abandoned(names):
    """Returns the names that end with the id of a process that no longer exists. Killed runs have left these groups."""
    return [name for name in names if not pathlib.Path(f"/proc/{str(name).rsplit('-', 1)[1]}").exists()]


def version():
    """Returns the version that can limit memory and disks: 1, 2 or None. A system with both versions has these controllers in
    version 1."""
    if all((ROOT / kind).is_dir() for kind in ("blkio", "memory")):
        return 1
    offered = ROOT / "cgroup.controllers"
    return 2 if offered.is_file() and set(CONTROLLERS) <= set(offered.read_text().split()) else None


def whole_disk(device):
    """Returns MAJOR:MINOR of the disk to which a partition belongs, because only whole disks can be throttled."""
    number = f"{os.major(device)}:{os.minor(device)}"
    there = pathlib.Path("/sys/dev/block", number)
    return (there.resolve().parent / "dev").read_text().strip() if (there / "partition").exists() else number


@contextlib.contextmanager
def made(groups):
    """Makes groups. The end of the `with` removes them."""
    for parent in {group.parent for group in groups}:
        for left in abandoned(parent.glob(f"{NAME}-*")):
            left.rmdir()
    with contextlib.ExitStack() as ending:
        for group in groups:
            group.mkdir()
            ending.callback(group.rmdir)
        yield


@contextlib.contextmanager
def version_1(disk, bytes_per_second, memory_bytes):
    throttled, limited = (ROOT / kind / f"{NAME}-{os.getpid()}" for kind in ("blkio", "memory"))
    with made([throttled, limited]):
        (throttled / "blkio.throttle.read_bps_device").write_text(f"{disk} {bytes_per_second}")
        (limited / "memory.limit_in_bytes").write_text(str(memory_bytes))
        yield [throttled, limited]


def move_all(there, to):
    for process in (there / "cgroup.procs").read_text().split():
        with contextlib.suppress(ProcessLookupError):  # the process has ended meanwhile
            (to / "cgroup.procs").write_text(process)


def switch(sign, controllers):
    (ROOT / "cgroup.subtree_control").write_text(" ".join(sign + name for name in controllers))


def make_room(rest):
    """Moves all processes of the root group into a group below it."""
    rest.mkdir()
    try:
        move_all(ROOT, rest)
        switch("+", CONTROLLERS)
    except BaseException:
        move_all(rest, ROOT)
        rest.rmdir()
        raise


def put_back(rest):
    switch("-", CONTROLLERS)
    move_all(rest, ROOT)
    rest.rmdir()


@contextlib.contextmanager
def controllers_below_the_root():
    """Enables the controllers for the children of the root group. A group may do this only if it has no processes of its own.
    The root of the system is exempt; the root of a container, which looks the same, is not."""
    lacking = [name for name in CONTROLLERS if name not in (ROOT / "cgroup.subtree_control").read_text().split()]
    rest = ROOT / f"{REST}-{os.getpid()}"
    with contextlib.ExitStack() as ending:
        if lacking:
            try:
                switch("+", lacking)
                ending.callback(switch, "-", lacking)
            except OSError as error:
                if error.errno != errno.EBUSY:
                    raise
                make_room(rest)
                ending.callback(put_back, rest)
        yield


@contextlib.contextmanager
def version_2(disk, bytes_per_second, memory_bytes):
    group = ROOT / f"{NAME}-{os.getpid()}"
    with contextlib.ExitStack() as stack:
        for rest in abandoned(ROOT.glob(f"{REST}-*")):
            put_back(rest)
        stack.enter_context(controllers_below_the_root())
        stack.enter_context(made([group]))
        (group / "io.max").write_text(f"{disk} rbps={bytes_per_second}")
        (group / "memory.max").write_text(str(memory_bytes))
        with contextlib.suppress(FileNotFoundError, PermissionError):  # a system without swap does not have this file
            (group / "memory.swap.max").write_text("0")
        yield [group]
