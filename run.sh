#!/usr/bin/env bash
# Builds Lodestream and shows a model: ./run.sh [MODEL] [OPTIONS of lodestream view or render], ./run.sh --web [MODEL]
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$root/build/release"
bin="$build/bin"
installer="$root/docker/install-packages.sh"
targets=(lodestreamd lodestream lodestream_library)
stamp="$build/built"  # as old as the start of the last build that succeeded
compile_cpu_s=150
sample_triangles=2000000
web_port=7480  # of --web; another one if it is taken
flags="--json --no-fade --offline --preview --unlit --version"  # options of the client without a value

usage() {
  cat <<'EOF'
usage: ./run.sh [MODEL.ply | STORE.lode | SCENE.json | lode://HOST:PORT/MODEL] [OPTIONS]
       ./run.sh --web [MODEL.ply | STORE.lode]

Installs missing packages, builds Lodestream and opens a window on the model; without a display it draws a
picture and prints its path. Without a model it makes one of two million triangles. Options go to the client:
lodestream view --help lists them; those of lodestream render --help if a picture is drawn, as with -o OUT.png.

With --web it serves the model on this machine, prints a link for a browser, and opens it if it can. Ctrl-C ends it.
EOF
}

say() { echo "run.sh: $*" >&2; }

fail() {
  say "$@"
  exit 1
}

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
    why="$1 is a pipe or a device; name a file: a store or a PLY"
  elif ! why="$(other_kind "$1" 2>/dev/null)"; then
    why="$1: cannot be read; check its permissions"
  elif [[ -n "$why" ]]; then
    why="$1 $why"
  fi
  [[ -z "$why" ]] || fail "$why"
}

# Finds the model among the options, and the option that names a picture.
read_arguments() {  # ARGUMENT...
  local word option=""  # option: the one that waits for its value
  for word in "$@"; do
    if [[ -n "$option" ]]; then
      [[ "$option" != "$picture_option" ]] || picture="$word"
      option=""
      options+=("$word")
      continue
    fi
    case "$word" in
      -h | --help)
        usage
        exit 0
        ;;
      --web)
        command=web
        continue
        ;;
      -o*) picture_option=-o picture="${word#-o}" ;;
      --output* | --frames* | --video*) picture_option="${word%%=*}" picture="${word#*=}" ;;
    esac
    case "$word" in
      --*=* | -o?*) options+=("$word") ;;
      --* | -o)
        options+=("$word")
        [[ " $flags " == *" $word "* ]] || option="$word"
        ;;
      -*) options+=("$word") ;;
      *)
        [[ -z "$model" ]] || fail "two models: $model and $word; name one"
        model="$word"
        ;;
    esac
  done
}

# Decides between a window and a picture, and refuses options that the chosen command lacks.
choose_command() {
  local word why
  if [[ -n "$picture_option" ]]; then
    why="leave out $picture_option"
  elif [[ -n "${DISPLAY:-}" ]]; then
    return
  else
    no_display="no display here (DISPLAY is not set)"
    [[ -z "${WAYLAND_DISPLAY:-}" ]] ||
      no_display="no X display here (DISPLAY is not set; the window needs Xwayland, package xwayland)"
    why="$no_display"
  fi
  command=render
  for word in "${options[@]}"; do
    case "${word%%=*}" in
      --laps | --screenshot | --no-fade) fail "${word%%=*} needs a window; $why" ;;
      --fps)
        [[ "$picture_option" == --frames || "$picture_option" == --video ]] ||
          fail "--fps needs --frames DIR or --video OUT.mp4, or a window; $why"
        ;;
    esac
  done
}

# Refuses what --web cannot show.
check_web() {
  [[ -z "${options[*]}" ]] || fail "--web takes no options; leave out ${options[*]}"
  [[ "$model" != *://* ]] || fail "$model is on a server; --web shows a PLY file or a store of this machine"
  [[ "${model,,}" != *.json ]] || fail "$model is a scene; --web shows one model: name one of the scene's"
}

# Prints a place of the build that this user cannot write, or nothing.
unwritable_place() {
  local place="$root/build"
  if [[ -d "$build" ]]; then
    find "$build" ! -type l ! -writable -print -quit 2>/dev/null || true
  else
    [[ -d "$place" ]] || place="$root"
    [[ -w "$place" ]] || echo "$place"
  fi
}

# Prints the folder of the checkout for which the build is configured, or nothing.
configured_folder() { sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt" 2>/dev/null || true; }

# Returns true if the programs are there and no source has changed since they were built.
are_current() {
  local sources=("$root"/{CMakeLists.txt,CMakePresets.json,cmake,common,proto,server,client})
  [[ -x "$bin/lodestreamd" && -x "$bin/lodestream" && -e "$stamp" && "$(configured_folder)" -ef "$root" ]] &&
    [[ -z "$(find "${sources[@]}" -newer "$stamp" -print -quit)" ]]
}

# Says what is missing and what that costs; then installs and compiles it.
prepare() {
  local place plan minutes compiles="" end="" sections=(run window)
  place="$(unwritable_place)"
  if [[ -n "$place" ]]; then
    are_current || fail "$(refusal "$place"), and the programs are missing or not known to be current; $(remedy "$place")"
    say "$(refusal "$place"): uses the programs that are there; they are current"
  else
    sections+=(build)
    if [[ ! -x "$bin/lodestream" || ! "$(configured_folder)" -ef "$root" ]]; then
      minutes=$(((compile_cpu_s / $(nproc) + 59) / 60))
      compiles="compiles for about $minutes minute$( ((minutes == 1)) || echo s) in $build"
      end=", the first time only"
    elif ! are_current; then
      compiles="compiles what has changed in $build"
    fi
  fi

  plan="$("$installer" --plan "${sections[@]}")" || exit 1
  if [[ -n "$plan" ]]; then
    say "installs $plan${compiles:+, then $compiles}${end:+; later runs need neither}"
    "$installer" "${sections[@]}"
  elif [[ -n "$compiles" ]]; then
    say "$compiles$end"
  fi
  [[ -z "$compiles" || -O "$root" ]] ||
    say "$root belongs to $(stat -c %U "$root"); what $(id -un) builds in it belongs to $(id -un)"
  [[ -n "$place" ]] || build_programs
}

refusal() {  # PLACE
  echo "$1 cannot be written by $(id -un 2>/dev/null) (it belongs to $(stat -c %U "$1"))"
}

remedy() {  # PLACE
  local copy="use a copy of your own: cp -r $root FOLDER"
  if [[ "$1" == "$build"* ]]; then echo "remove $build as $(stat -c %U "$1"), or $copy"; else echo "$copy"; fi
}

build_programs() {
  local old how=()
  old="$(configured_folder)"
  if [[ -n "$old" && ! "$old" -ef "$root" ]]; then
    say "the checkout was built in $old: configures anew"
    how=(--fresh)
  fi
  if [[ -n "${how[*]}" || ! -f "$build/build.ninja" || "$root/CMakePresets.json" -nt "$build/build.ninja" ]]; then
    mkdir -p "$build"
    if ! (cd "$root" && cmake "${how[@]}" --preset release -DLODE_TESTS=OFF) >"$build/configure.log" 2>&1; then
      cat "$build/configure.log" >&2
      fail "cmake could not configure the build; the lines above say why"
    fi
  fi
  : >"$stamp.new"
  cmake --build "$build" --target "${targets[@]}" >&2 || fail "the build failed; the lines above say where"
  mv "$stamp.new" "$stamp"
}

# Sets outputs to the folder for the sample and for pictures: build/, or the user's cache if build/ cannot be written.
choose_outputs() {
  outputs="$root/build"
  if [[ ! -w "$outputs" ]]; then
    outputs="${XDG_CACHE_HOME:-${HOME:-$PWD}/.cache}/lodestream"
    mkdir -p -m 700 "$outputs"
  fi
}

make_sample() {  # sets model to its path
  model="$root/build/sample/asteroid.ply"
  [[ ! -s "$model" ]] || return 0
  model="$outputs/sample/asteroid.ply"
  [[ ! -s "$model" ]] || return 0
  say "no model given: makes $model with $sample_triangles triangles"
  mkdir -p "$outputs/sample"
  "$bin/lodestreamd" sample asteroid --triangles "$sample_triangles" --attributes normal,color -o "$model" >&2
}

is_port_taken() {  # PORT
  (: <"/dev/tcp/127.0.0.1/$1") 2>/dev/null
}

# Reads the line that the server prints when it is ready, and shows its page.
show_page() {
  local ready link
  IFS= read -r ready || return 0  # the server has said why it does not start
  [[ "$ready" =~ \"link\":\"([^\"]+)\" ]] || return 0
  link="${BASH_REMATCH[1]}"
  say "$link shows $model in a browser; Ctrl-C ends the server"
  [[ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]] && command -v xdg-open >/dev/null || return 0
  xdg-open "$link" >/dev/null 2>&1 || say "no browser could be opened; open the link yourself"
}

serve_page() {
  local store port=$web_port
  store="$("$bin/lodestream" store "$model")" || exit
  ! is_port_taken "$port" || port=0
  exec "$bin/lodestreamd" serve "$store" --listen 127.0.0.1:0 --http "127.0.0.1:$port" > >(show_page)
}

model="" options=() picture_option="" picture="" command=view no_display=""
read_arguments "$@"
[[ -z "$model" || "$model" == *://* ]] || check_model "$model"
if [[ "$command" == web ]]; then check_web; else choose_command; fi
prepare
choose_outputs
[[ -n "$model" ]] || make_sample

[[ "$command" != web ]] || serve_page
if [[ "$command" == view ]]; then
  say "opens $model: drag to turn; F1 shows the keys; Esc leaves"
  exec "$bin/lodestream" view "$model" "${options[@]}"
fi
if [[ -z "$picture_option" ]]; then
  picture="$(basename "$model")"
  picture="$outputs/${picture%.*}.png"
  options+=(-o "$picture")
fi
say "${no_display:+$no_display: }draws a picture of $model"
"$bin/lodestream" render "$model" "${options[@]}"
say "the picture is in $picture"
