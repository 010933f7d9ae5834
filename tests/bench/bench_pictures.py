#!/usr/bin/env python3
"""Pictures of one-pixel cuts beside full resolution: bench_pictures.py BIN_DIR MODEL.ply ... [--pixels P]

Builds each model, draws it from eight places (along the axes, and two close ones) at an error of P pixels and of 0.01,
which is all leaves, and has bench_fidelity compare each pair.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

FULL_PX = "0.01"
DIRECTIONS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 1), (-1, 1, -1)]
CLOSE = 6  # directions from here on are seen from half the distance


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    parser.add_argument("--pixels", default="1")
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    for model in options.models:
        with tempfile.TemporaryDirectory() as folder:
            compare(options, model, pathlib.Path(folder))


def compare(options, model, folder):
    store = folder / "model.lode"
    daemon = str(options.bin_dir / "lodestreamd")
    subprocess.run([daemon, "build", str(model), "-o", str(store), "--quiet"], check=True)
    info = json.loads(subprocess.run([daemon, "info", str(store), "--json"], check=True, capture_output=True).stdout)
    print(f"{model.name}: {info['triangles']} triangles, {', '.join(info['attributes'])}", flush=True)
    pairs = []
    for number, direction in enumerate(DIRECTIONS):
        camera = folder / f"{number}.json"
        camera.write_text(json.dumps(camera_at(info["box"], direction, 0.5 if number >= CLOSE else 1)))
        triangles = {}
        for pixels in (FULL_PX, options.pixels):
            picture = folder / f"{number}_{pixels}.png"
            client = [str(options.bin_dir / "lodestream")]
            of_camera = [str(store), "--camera", str(camera), "--size", options.size, "--pixels", pixels]
            # The lattice's own error may stay above the threshold of full resolution: the exit status says so.
            subprocess.run([*client, "render", *of_camera, "-o", str(picture)], check=pixels != FULL_PX,
                           stderr=subprocess.DEVNULL if pixels == FULL_PX else None)
            fetched = subprocess.run([*client, "fetch", *of_camera, "--json"], capture_output=True).stdout
            triangles[pixels] = json.loads(fetched)["triangles"]
            pairs.append(str(picture))
        print(f"  {direction}: {triangles[options.pixels]} triangles of {triangles[FULL_PX]}", flush=True)
    subprocess.run([str(options.bin_dir / "bench_fidelity"), "--pictures", *pairs], check=True)


def camera_at(box, direction, distance):
    centre = [(low + high) / 2 for low, high in zip(box["min"], box["max"])]
    away = 1.1 * distance * math.dist(box["min"], box["max"]) / math.hypot(*direction)
    eye = [c + away * d for c, d in zip(centre, direction)]
    up = [0, 0, 1] if direction[2] == 0 else [0, 1, 0]
    return {"fov_y_deg": 45, "keys": [{"t": 0, "eye": eye, "target": centre, "up": up}]}


if __name__ == "__main__":
    main()
