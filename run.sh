#!/usr/bin/env bash
# Builds Lodestream and shows a model: ./run.sh [MODEL] [OPTIONS of lodestream view or render]
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$root/build/release"
sample_triangles=2000000

usage() {
  cat <<'EOF'
usage: ./run.sh [MODEL.ply | STORE.lode | lode://HOST:PORT/MODEL] [OPTIONS]

Installs missing packages, builds Lodestream and opens a window on the model; without a display it draws a
picture and prints its path. Without a model it makes one of two million triangles. Options go to the client:
lodestream view --help (without a display lodestream render --help) lists them.
EOF
}

say() { echo "run.sh: $*" >&2; }

build_programs() {
  mkdir -p "$build"
  if ! {
    (cd "$root" && cmake --preset release -DLODE_TESTS=OFF) >"$build/configure.log" 2>&1
  }; then
    cat "$build/configure.log" >&2
    say "cmake could not configure the build; the lines above say why"
    exit 1
  fi
  if ! cmake --build "$build" --target lodestreamd lodestream >&2; then
    say "the build failed; the lines above say where"
    exit 1
  fi
}

make_sample() {  # prints its path
  local sample="$root/build/sample/asteroid.ply"
  if [[ ! -s "$sample" ]]; then
    say "no model given: making $sample with $sample_triangles triangles"
    mkdir -p "$(dirname "$sample")"
    "$build/bin/lodestreamd" sample asteroid --triangles "$sample_triangles" --attributes normal,color \
      -o "$sample" >&2
  fi
  echo "$sample"
}

model=""
case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
  "" | -*) ;;
  *)
    model="$1"
    shift
    if [[ "$model" != lode*://* && ! -f "$model" ]]; then
      say "no such file: $model; name a PLY mesh, or nothing for a sample model"
      exit 1
    fi
    ;;
esac

"$root/docker/install-packages.sh" run window build
say "building in $build (the first time takes a few minutes)"
build_programs
[[ -n "$model" ]] || model="$(make_sample)"

if [[ -n "${DISPLAY:-}" ]]; then
  say "opening $model: drag to turn; F1 shows the keys; Esc leaves"
  exec "$build/bin/lodestream" view "$model" "$@"
fi

picture=""
previous=""
for argument in "$@"; do
  case "$previous" in -o | --output | --frames | --video) picture="$argument" ;; esac
  case "$argument" in --output=* | --frames=* | --video=*) picture="${argument#*=}" ;; esac
  previous="$argument"
done
if [[ -z "$picture" ]]; then
  name="$(basename "$model")"
  picture="$root/build/${name%.*}.png"
  set -- "$@" -o "$picture"
fi
say "no display here (DISPLAY is not set): drawing a picture of $model"
"$build/bin/lodestream" render "$model" "$@"
say "the picture is in $picture"
