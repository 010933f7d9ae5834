#!/usr/bin/env python3
"""Plain files against SQLite as a cache of blobs: time of the processor a blob, and bytes of disk a byte.

usage: bench_cache.py [BLOBS, default 4000]

Both keep blobs of 0.6 to 40 KB by name, read them in another order and note their use. SQLite writes 16 a transaction, to a
write-ahead log that it syncs only at checkpoints; files are written beside, renamed and not synced.
"""

import hashlib
import os
import random
import resource
import sqlite3
import sys
import tempfile

SIZES = [600, 2000, 8000, 20000, 40000]
BATCH = 16


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def report(what, count, work):
    before = cpu_seconds()
    work()
    print(f"{what}: {(cpu_seconds() - before) * 1e6 / count:.0f} us of CPU a blob")


class Files:
    def __init__(self, folder):
        self.folder = folder

    def path(self, name):
        return f"{self.folder}/{name.hex()[:2]}/{name.hex()}"

    def keep(self, blobs):
        for name, data in blobs:
            path = self.path(name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path + ".new", "wb", buffering=0) as file:
                file.write(data)
            os.rename(path + ".new", path)

    def read(self, names):
        for name in names:
            with open(self.path(name), "rb", buffering=0) as file:
                file.read()
            os.utime(self.path(name))


class Sqlite:
    def __init__(self, folder):
        self.base = sqlite3.connect(f"{folder}/cache.db", isolation_level=None)
        self.base.execute("pragma journal_mode=wal")
        self.base.execute("pragma synchronous=normal")
        self.base.execute("create table blobs(id integer primary key, name blob unique, used integer, bytes blob)")

    def batches(self, items, work):
        for i in range(0, len(items), BATCH):
            self.base.execute("begin immediate")
            for item in items[i : i + BATCH]:
                work(item)
            self.base.execute("commit")

    def keep(self, blobs):
        self.batches(blobs, lambda blob: self.base.execute("insert into blobs(name, used, bytes) values(?, 0, ?)", blob))

    def read(self, names):
        def one(name):
            self.base.execute("select bytes from blobs where name=?", (name,)).fetchone()
            self.base.execute("update blobs set used=1 where name=?", (name,))

        self.batches(names, one)


def disk_bytes(folder):
    return sum(os.stat(os.path.join(at, name)).st_blocks * 512 for at, _, names in os.walk(folder) for name in names)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
    random.seed(1)
    blobs = [(hashlib.sha256(data).digest()[:16], data) for data in (random.randbytes(random.choice(SIZES)) for _ in range(count))]
    names = [name for name, _ in blobs]
    random.shuffle(names)
    raw_bytes = sum(len(data) for _, data in blobs)
    for kind in (Files, Sqlite):
        with tempfile.TemporaryDirectory() as folder:
            cache = kind(folder)
            report(f"{kind.__name__.lower()} keep", count, lambda: cache.keep(blobs))
            report(f"{kind.__name__.lower()} read", count, lambda: cache.read(names))
            print(f"{kind.__name__.lower()}: {disk_bytes(folder) / raw_bytes:.2f} bytes of disk a byte")


if __name__ == "__main__":
    main()
