"""Control groups of version 1 or 2 for a command whose memory and whose disk are to be small. As root; each ends in the number of
the process that made it, and one whose process is gone is cleared up by the next.
"""
import contextlib
import errno
import os
import pathlib

ROOT = pathlib.Path("/sys/fs/cgroup")
NAME, REST = "lode-bench", "lode-rest"
CONTROLLERS = ("memory", "io")


def abandoned(names):
    """Those that end in the number of a process which is gone: runs that were killed left them."""
    return [name for name in names if not pathlib.Path(f"/proc/{str(name).rsplit('-', 1)[1]}").exists()]


def version():
    """1, 2, or None where neither has what limits memory and disks; 1 where a system has both, as it is there that these are."""
    if all((ROOT / kind).is_dir() for kind in ("blkio", "memory")):
        return 1
    offered = ROOT / "cgroup.controllers"
    return 2 if offered.is_file() and set(CONTROLLERS) <= set(offered.read_text().split()) else None


def whole_disk(device):
    """MAJOR:MINOR of the disk that a partition is of: only disks can be throttled."""
    number = f"{os.major(device)}:{os.minor(device)}"
    there = pathlib.Path("/sys/dev/block", number)
    return (there.resolve().parent / "dev").read_text().strip() if (there / "partition").exists() else number


@contextlib.contextmanager
def made(groups):
    """Groups that go with the `with`."""
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
        with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
            (to / "cgroup.procs").write_text(process)


def switch(sign, controllers):
    (ROOT / "cgroup.subtree_control").write_text(" ".join(sign + name for name in controllers))


def make_room(rest):
    """All processes of the root move into a group below it."""
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
    """Children have a controller's files where their parent hands it on, which only one may that has no processes of its own: the
    system's root is exempt, a container's, which looks like it, is not."""
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
        with contextlib.suppress(FileNotFoundError, PermissionError):  # a system without swap has none
            (group / "memory.swap.max").write_text("0")
        yield [group]
