#!/usr/bin/env python3
"""Compares pictures of one-pixel cuts with full resolution: bench_pictures.py BIN_DIR MODEL.ply ... [--pixels P]

--painted N ... adds samples of N triangles with texture coordinates and a picture of rings, stripes and a gradient.
Builds each model, draws it from eight places at a threshold of P pixels and of 0.01 pixels (all leaves), and compares the
pictures by bench_fidelity: peak signal-to-noise ratios over the cameras whose pictures differ.
"""
import argparse
import json
import math
import pathlib
import struct
import subprocess
import tempfile
import zlib

from rows import print_row

FULL_PX = "0.01"
DIRECTIONS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 1), (-1, 1, -1)]
PICTURE_SIDE = 2048
CLOSE = 6  # directions from here on are seen from half the distance


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    parser.add_argument("--painted", type=int, nargs="*", default=[], metavar="N")
    parser.add_argument("--pixels", default="1")
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    for triangles in options.painted:
        with tempfile.TemporaryDirectory() as folder:
            compare(options, painted_sample(options, triangles, pathlib.Path(folder)), pathlib.Path(folder))
    for model in options.models:
        with tempfile.TemporaryDirectory() as folder:
            compare(options, model, pathlib.Path(folder))


def painted_sample(options, triangles, folder):
    model, bare = folder / f"painted{triangles}.ply", folder / "bare.ply"
    subprocess.run([str(options.bin_dir / "lodestreamd"), "sample", "asteroid", "--triangles", str(triangles),
                    "--attributes", "uv", "-o", str(bare)], check=True, stdout=subprocess.DEVNULL)
    header, rest = bare.read_bytes().split(b"element vertex", 1)
    model.write_bytes(header + b"comment TextureFile painted.png\nelement vertex" + rest)
    (folder / "painted.png").write_bytes(png(PICTURE_SIDE, painted_rows()))
    return model


def painted_rows():
    for y in range(PICTURE_SIDE):
        row = bytearray(b"\0")
        for x in range(PICTURE_SIDE):
            ring = math.hypot(x - PICTURE_SIDE / 2, y - PICTURE_SIDE / 2) // 64 % 2
            stripe = (x + y) // 96 % 2
            row += bytes((round(60 + 120 * ring), round(40 + 140 * stripe), 80 + 100 * x // PICTURE_SIDE))
        yield bytes(row)


def png(side, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(rows), 6)) +
            chunk(b"IEND", b""))


def compare(options, model, folder):
    store = folder / "model.lode"
    daemon = str(options.bin_dir / "lodestreamd")
    subprocess.run([daemon, "build", str(model), "-o", str(store), "--quiet"], check=True)
    info = json.loads(subprocess.run([daemon, "info", str(store), "--json"], check=True, capture_output=True).stdout)
    pairs, drawn = [], []
    for number, direction in enumerate(DIRECTIONS):
        camera = folder / f"{number}.json"
        camera.write_text(json.dumps(camera_at(info["box"], direction, 0.5 if number >= CLOSE else 1)))
        for pixels in (FULL_PX, options.pixels):
            picture = folder / f"{number}_{pixels}.png"
            client = [str(options.bin_dir / "lodestream")]
            of_camera = [str(store), "--camera", str(camera), "--size", options.size, "--pixels", pixels]
            # Ignore the exit status: at such a small threshold, the error of the lattice may exceed it.
            subprocess.run([*client, "render", *of_camera, "-o", str(picture)], check=False, stderr=subprocess.DEVNULL)
            pairs.append(str(picture))
        fetched = subprocess.run([*client, "fetch", *of_camera, "--json"], capture_output=True).stdout
        drawn.append(json.loads(fetched)["triangles"])
    said = subprocess.run([str(options.bin_dir / "bench_fidelity"), "--pictures", *pairs], check=True, capture_output=True, text=True).stdout
    rows = [json.loads(line) for line in said.splitlines()]
    inside, boundary = ([row[key] for row in rows if row[key] is not None] for key in ("inside_db", "with_boundary_db"))
    differing = {"worst_db": min(inside), "best_db": max(inside), "worst_with_boundary_db": min(boundary)} if inside else {}
    print_row(model=model.stem, triangles=info["triangles"], drawn_least=min(drawn), drawn_most=max(drawn), **differing)


def camera_at(box, direction, distance):
    centre = [(low + high) / 2 for low, high in zip(box["min"], box["max"])]
    away = 1.1 * distance * math.dist(box["min"], box["max"]) / math.hypot(*direction)
    eye = [c + away * d for c, d in zip(centre, direction)]
    up = [0, 0, 1] if direction[2] == 0 else [0, 1, 0]
    return {"fov_y_deg": 45, "keys": [{"t": 0, "eye": eye, "target": centre, "up": up}]}


if __name__ == "__main__":
    main()
