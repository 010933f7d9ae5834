#!/usr/bin/env bash
# Builds Lodestream and shows a model: ./run.sh [MODEL] [OPTIONS of lodestream view or render]
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$root/build/release"
sample_triangles=2000000

usage() {
  cat <<'EOF'
usage: ./run.sh [MODEL.ply | STORE.lode | SCENE.json | lode://HOST:PORT/MODEL] [OPTIONS]

Installs missing packages, builds Lodestream and opens a window on the model; without a display it draws a
picture and prints its path. Without a model it makes one of two million triangles. Options go to the client:
lodestream view --help (without a display lodestream render --help) lists them.
EOF
}

say() { echo "run.sh: $*" >&2; }

# Prints what a file is if it is neither a PLY file nor a store, by its first bytes; by its ending only for formats
# without a signature. The programs know more kinds (common/io/foreign_file.cpp), but are not built yet.
other_kind() {  # FILE
  local start ending="${1##*.}"
  start="$(od -An -v -tx1 -N 16 -- "$1" | tr -d ' \n')" || return 1
  case "$start" in
    "") echo "is empty; copy or export it again" ;;
    706c79* | efbbbf706c79* | 4c4f44450d0a*) ;;  # a PLY file, a store; the programs check the rest
    504b0304*)
      if [[ "${ending,,}" == 3mf ]]; then mesh_words "a 3MF" "$1"; else echo "is a zip archive; unpack it first"; fi
      ;;
    1f8b* | 425a68* | fd377a585a00* | 28b52ffd* | 377abcaf271c* | 526172211a07* | 04224d18* | 1f9d* | 4c5a4950*)
      echo "is compressed or an archive; unpack it first"
      ;;
    89504e47* | ffd8ff* | 47494638* | 49492a00* | 4d4d002a* | 52494646????????57454250*)
      echo "is a picture, neither a PLY file nor a store; name the PLY file of the mesh"
      ;;
    676c5446*) mesh_words "a GLB (binary glTF)" "$1" ;;
    4b617964617261*) mesh_words "an FBX" "$1" ;;
    *)
      case "${ending,,}" in
        obj | off | stl | fbx) mesh_words "an ${ending^^}" "$1" ;;
        gltf) mesh_words "a glTF" "$1" ;;
        dae) mesh_words "a COLLADA" "$1" ;;
        json) ;;  # a scene
        *) echo "is neither a PLY file nor a store; Lodestream reads PLY" ;;
      esac
      ;;
  esac
}

mesh_words() {  # KIND FILE
  local file converted
  printf -v file '%q' "$2"
  printf -v converted '%q' "${2%.*}.ply"
  [[ "$file" != "$converted" ]] || printf -v converted '%q' "${2%.*}.converted.ply"
  echo "is $1, neither a PLY file nor a store; Lodestream reads PLY: convert it (MeshLab, Blender," \
    "\`assimp export $file $converted\`)"
}

# Refuses what no program could show, before packages are installed and the programs are built.
check_model() {  # FILE
  local why
  if [[ ! -e "$1" ]]; then
    why="no such file: $1; name a PLY mesh, or nothing for a sample model"
  elif [[ -d "$1" ]]; then
    why="$1 is a directory; name a store or a PLY in it"
  elif [[ ! -f "$1" ]]; then
    why="$1 is a pipe or a device; name a store or a PLY, a file"
  elif ! why="$(other_kind "$1" 2>/dev/null)"; then
    why="$1: cannot be read; check its permissions"
  elif [[ -n "$why" ]]; then
    why="$1 $why"
  fi
  [[ -z "$why" ]] || { say "$why"; exit 1; }
}

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
    [[ "$model" == *://* ]] || check_model "$model"
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
