#!/usr/bin/python3
"""Tests lodestreamd with the Python client: read_model_test.py BIN_DIR MODELS_DIR."""
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

from read_model import NO_SUCH_MODEL

BIN, MODELS = sys.argv.pop(1), sys.argv.pop(1)
CLIENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "read_model.py")
HEADER_AND_FOOTER_BYTES, TABLE_ENTRY_BYTES = 212, 28  # sizes in a store: docs/store-format.md


def daemon(*arguments):
    return subprocess.run([os.path.join(BIN, "lodestreamd"), *arguments], check=True, capture_output=True, text=True).stdout


def write_png(path, width, height, seed):
    random.seed(seed)
    rows = b"".join(b"\0" + random.randbytes(3 * width) for _ in range(height))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as png:
        png.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)))
        png.write(chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def write_textured(path, edge):
    """Writes a flat sheet of edge x edge squares, with a texture of three levels."""
    write_png(os.path.join(os.path.dirname(path), "sheet.png"), 1100, 300, seed=1)
    with open(path, "w") as ply:
        ply.write(f"ply\nformat ascii 1.0\ncomment TextureFile sheet.png\nelement vertex {(edge + 1) ** 2}\n")
        ply.write("".join(f"property float {name}\n" for name in "xyzst"))
        ply.write(f"element face {edge ** 2}\nproperty list uchar int vertex_indices\nend_header\n")
        for y in range(edge + 1):
            for x in range(edge + 1):
                ply.write(f"{x} {y} {(x * y) % 3} {x / edge} {y / edge}\n")
        for y in range(edge):
            for x in range(edge):
                at = y * (edge + 1) + x
                ply.write(f"4 {at} {at + 1} {at + edge + 2} {at + edge + 1}\n")


class ReadModel(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        sheet = os.path.join(self.folder.name, "sheet.ply")
        write_textured(sheet, 60)
        self.stores = {"painted": os.path.join(MODELS, "painted.lode"), "sheet": sheet.replace(".ply", ".lode")}
        daemon("build", sheet, "-o", self.stores["sheet"], "--triangles-per-node", "1024", "--quiet")
        self.server = subprocess.Popen(
            [os.path.join(BIN, "lodestreamd"), "serve", *self.stores.values(), "--listen", "127.0.0.1:0"],
            stdout=subprocess.PIPE, text=True)
        self.address = json.loads(self.server.stdout.readline())["listen"]

    def tearDown(self):
        self.server.terminate()
        self.server.wait()
        self.server.stdout.close()
        self.folder.cleanup()

    def read(self, model):
        return subprocess.run([sys.executable, CLIENT, self.address, model], capture_output=True, text=True)

    def expect_whole(self, model):
        done = self.read(model)
        self.assertEqual(done.returncode, 0, done.stderr)
        read = json.loads(done.stdout)
        store = json.loads(daemon("info", self.stores[model], "--json"))
        self.assertEqual(read["payloads"], store["payloads"])
        self.assertEqual(HEADER_AND_FOOTER_BYTES + TABLE_ENTRY_BYTES * read["blobs"] + read["bytes"], store["bytes"])
        return read

    def test_every_blob_of_a_model_is_read(self):
        self.expect_whole("painted")

    def test_every_tile_of_a_textured_model_is_read(self):
        self.assertEqual(self.expect_whole("sheet")["tiles"], 3 + 2 + 1)

    def test_an_unknown_model_is_reported(self):
        done = self.read("nothing")
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"code {NO_SUCH_MODEL}", done.stderr)


if __name__ == "__main__":
    unittest.main()
