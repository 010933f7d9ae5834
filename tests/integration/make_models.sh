#!/usr/bin/env bash
# Makes the models that integration tests share: make_models.sh BIN_DIR OUT_DIR. Scans come from
# LODESTREAM_TEST_DATA. If LODESTREAM_MADE_MODELS is the folder of models that another build of the same
# programs has made, the script copies these.
set -euo pipefail

daemon="$1/lodestreamd"
out="$2"
mkdir -p "$out"
if [[ -n "${LODESTREAM_MADE_MODELS:-}" ]]; then
  cp -R "$LODESTREAM_MADE_MODELS"/. "$out"
  exit 0
fi

"$daemon" sample asteroid --triangles 2000000 --seed 1 -o "$out/asteroid2m.ply" >/dev/null
"$daemon" build "$out/asteroid2m.ply" -o "$out/asteroid2m.lode" --quiet >/dev/null
"$daemon" sample asteroid --triangles 60000 --seed 2 --attributes normal,color -o "$out/painted.ply" >/dev/null
"$daemon" build "$out/painted.ply" -o "$out/painted.lode" --triangles-per-node 1024 --quiet >/dev/null
"$daemon" build "$out/painted.ply" -o "$out/painted_in_small_nodes.lode" --triangles-per-node 512 --quiet >/dev/null
"$daemon" sample gyroid --triangles 60000 --seed 3 -o "$out/gyroid.ply" >/dev/null
"$daemon" build "$out/gyroid.ply" -o "$out/gyroid.lode" --triangles-per-node 1024 --quiet >/dev/null

data="${LODESTREAM_TEST_DATA:-}"
if [[ -z "$data" ]]; then
  echo "LODESTREAM_TEST_DATA is not set: the tests of scans will be skipped"
  exit 0
fi
"$daemon" build "$data/a_bunny_zipper_ascii.ply" -o "$out/bunny.lode" --quiet >/dev/null
"$daemon" build "$data/a_armadillo86k_le.ply" -o "$out/armadillo.lode" --triangles-per-node 2048 --quiet >/dev/null
"$daemon" build "$data/a_bunny_zipper_ascii.ply" -o "$out/bunny_in_small_nodes.lode" --triangles-per-node 256 --quiet \
  >/dev/null
"$daemon" build "$data/b_parasaurolophus_nrm_ascii.ply" -o "$out/parasaurolophus.lode" --triangles-per-node 256 --quiet \
  >/dev/null
