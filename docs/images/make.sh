#!/usr/bin/env bash
# Makes the pictures of README.md and docs/gallery.md: docs/images/make.sh BIN_DIR
set -euo pipefail

bin="$(cd "${1:?usage: docs/images/make.sh BIN_DIR}" && pwd)"
cd "$(dirname "${BASH_SOURCE[0]}")"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

sample() {  # NAME OPTIONS of sample...
  "$bin/lodestreamd" sample "${@:2}" -o "$work/$1.ply" >/dev/null
  "$bin/lodestreamd" build "$work/$1.ply" -o "$work/$1.lode" --triangles-per-node 4096 --quiet
}

picture() {  # NAME MODEL WIDTHxHEIGHT OPTIONS of render...
  "$bin/lodestream" render "$work/$2.lode" --size "$3" "${@:4}" -o "$1.png" --json >/dev/null
}

sample asteroid asteroid --triangles 2000000 --attributes normal,color
sample terrain terrain --triangles 1000000 --attributes normal,color
sample gyroid gyroid --triangles 500000

picture asteroid asteroid 960x540
picture terrain terrain 640x360
picture gyroid gyroid 640x360
for show in unlit wireframe normals nodes lods errors; do
  pixels=1
  [[ "$show" != wireframe ]] || pixels=24
  picture "terrain_$show" terrain 640x360 --show "$show" --pixels "$pixels"
done

# A real scan, from the test data (Stanford Computer Graphics Laboratory).
if [[ -n "${LODESTREAM_TEST_DATA:-}" ]]; then
  "$bin/lodestreamd" build "$LODESTREAM_TEST_DATA/a_armadillo86k_le.ply" -o "$work/armadillo.lode" --quiet
  picture armadillo armadillo 800x450
fi

"$bin/lodestreamd" sample scene --triangles 100000 -o "$work/scene" >/dev/null
printf '{"keys":[{"t":0,"eye":[-3,-5,3.6],"target":[11,10,0],"up":[0,0,1]}]}' >"$work/scene_camera.json"
XDG_CACHE_HOME="$work/cache" "$bin/lodestream" render "$work/scene/scene.json" --camera "$work/scene_camera.json" \
  --size 960x540 -o scene.png --json >/dev/null

# The window with its panel, driven by keys and a pointer.
if command -v Xvfb >/dev/null && command -v xdotool >/dev/null; then
  ./window_pictures.py "$bin" "$work"
else
  echo "make.sh: Xvfb or xdotool is missing: the window's pictures stay as they are" >&2
fi

# The page in a browser.
if command -v Xvfb >/dev/null && command -v chromedriver >/dev/null && [[ -e "$work/armadillo.lode" && -x "$bin/wan" && "$EUID" == 0 ]]; then
  ./browser_pictures.py "$bin" "$work"
else
  echo "make.sh: Xvfb, chromedriver, LODESTREAM_TEST_DATA, $bin/wan or root is missing: the page's pictures stay as they are" >&2
fi

# A refining model: each picture allows a smaller error than the one before.
frames=()
for pixels in 45 32 23 16 11 8 5.6 4 2.8 1; do
  "$bin/lodestream" render "$work/asteroid.lode" --size 480x270 --pixels "$pixels" -o "$work/sharp_$pixels.png" --json >/dev/null
  time_ms=300
  [[ "$pixels" != 1 && "$pixels" != 45 ]] || time_ms=1500
  frames+=("$time_ms:$work/sharp_$pixels.png")
done
./animate.py asteroid_sharpening.png "${frames[@]}"
