#!/usr/bin/env python3
"""Measures builds of an edited scan with --reuse: bench_reuse.py BIN_DIR [--triangles N] [--edits PART...] [--json]

Makes an asteroid and builds it with --reuse. For each edit, moves the vertices of one cap that has this part of all vertices, and
builds the edited scan with --reuse and, on the same lattice, without it; both must give the same bytes. Figures are CPU seconds of
one thread, bytes of the new store's blobs that the old one lacks, and bytes that a client receives that has seen all of the old
model and asks for all of the new one, or for the first view of it; each also as part of the whole.
"""
import argparse
import filecmp
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

from rows import print_row

sys.path.append(str(pathlib.Path(__file__).parent.parent / "load"))
from processes import free_port, running, wait_for  # noqa: E402

VERTEX = struct.Struct("<3f")
FINEST_PX, FIRST_VIEW_PX = 0.01, 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=10_000_000)
    parser.add_argument("--edits", type=float, nargs="*", default=[0.001, 0.01, 0.1])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options.bin_dir.resolve(), pathlib.Path(folder))
        bench.sample(options.triangles)
        for part in options.edits:
            row = bench.edit_and_build(part)
            if options.json:
                print_row(model="asteroid", **row)
            else:
                print(", ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()),
                      flush=True)


class Bench:
    def __init__(self, bin_dir, folder):
        self.daemon, self.client, self.folder = bin_dir / "lodestreamd", bin_dir / "lodestream", folder
        self.scan, self.edited, self.reuse = folder / "scan.ply", folder / "edited.ply", folder / "reuse"
        for name in ("old", "with", "without"):
            (folder / name).mkdir()
        self.old, self.new, self.plain = (folder / name / "model.lode" for name in ("old", "with", "without"))

    def sample(self, triangles):
        subprocess.run([self.daemon, "sample", "asteroid", "--triangles", str(triangles), "-o", self.scan], check=True,
                       stdout=subprocess.DEVNULL)
        self.build(self.scan, self.old, "--reuse", self.reuse)

    def build(self, scan, store, *arguments):
        done = subprocess.run([self.daemon, "build", scan, "-o", store, "--threads", "1", "--quiet", "--json", *arguments], check=True,
                              stdout=subprocess.PIPE)
        return json.loads(done.stdout)["cpu_seconds"]

    def edit(self, part):
        """Moves the vertices of a cap towards the centre. @return their number."""
        data = bytearray(self.scan.read_bytes())
        body = data.index(b"end_header\n") + len(b"end_header\n")
        count = int(data.split(b"element vertex ", 1)[1].split(b"\n", 1)[0])
        end = body + count * VERTEX.size
        axis = (0.48, 0.6, 0.64)
        heights = sorted((sum(a * x for a, x in zip(axis, vertex)) / math.hypot(*vertex) for vertex in VERTEX.iter_unpack(data[body:end])),
                         reverse=True)
        least = heights[int(part * count)]
        moved = 0
        for number, vertex in enumerate(VERTEX.iter_unpack(bytes(data[body:end]))):
            height = sum(a * x for a, x in zip(axis, vertex)) / math.hypot(*vertex)
            if height > least:
                VERTEX.pack_into(data, body + number * VERTEX.size, *(x * (1 - 0.02 * (height - least)) - 1e-4 * x for x in vertex))
                moved += 1
        self.edited.write_bytes(data)
        return moved / count

    def edit_and_build(self, part):
        moved = self.edit(part)
        reuse = self.folder / "reuse-copy"
        shutil.copytree(self.reuse, reuse)
        cpu_s = self.build(self.edited, self.new, "--lattice-of", self.old, "--reuse", reuse)
        shutil.rmtree(reuse)
        plain_cpu_s = self.build(self.edited, self.plain, "--lattice-of", self.old)
        if not filecmp.cmp(self.new, self.plain, shallow=False):
            sys.exit("--reuse changes the bytes of the store")
        row = {"moved": moved, "cpu_s": cpu_s, "plain_cpu_s": plain_cpu_s, "cpu_part": cpu_s / plain_cpu_s,
               "store_bytes": self.new.stat().st_size}
        for view, px in (("all", FINEST_PX), ("first", FIRST_VIEW_PX)):
            cache = self.folder / "cache"
            whole = self.fetch(self.old, px, cache)
            anew = self.fetch(self.new, px, cache)
            shutil.rmtree(cache)
            row |= {f"{view}_bytes": whole, f"{view}_anew": anew, f"{view}_part": anew / whole}
        return row

    def fetch(self, store, px, cache):
        port = free_port()
        with running([self.daemon, "serve", store, "--listen", f"127.0.0.1:{port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            wait_for(port)
            done = subprocess.run([self.client, "fetch", f"lode://127.0.0.1:{port}/model", "--pixels", str(px), "--cache", cache,
                                   "--memory-budget", "8GB", "--json"], check=True, stdout=subprocess.PIPE)
        report = json.loads(done.stdout)
        if not report["converged"]:
            sys.exit("the client has not converged")
        return report["bytes_received"]


if __name__ == "__main__":
    main()
