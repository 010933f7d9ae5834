#!/usr/bin/env bash
# Makes client/web/dist, and client/web/dist.sha256 with the checksums of its sources: client/web/build.sh
# Needs Debian 13, for emscripten. On other systems, run as root and name a folder that becomes a Debian 13
# system, about 2 GB: client/web/build.sh --root FOLDER. The same sources give the same bytes.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
web="$root/client/web"

fail() {
  echo "build.sh: $*" >&2
  exit 1
}

# Runs this script in a Debian 13 root, and makes the root if it does not exist.
build_in() {  # FOLDER
  local folder="$1"
  [[ $EUID == 0 ]] || fail "--root needs root, for debootstrap and chroot"
  [[ -x "$folder/usr/bin/apt-get" ]] || debootstrap --variant=minbase trixie "$folder"
  mkdir -p "$folder/lodestream"
  cp /etc/resolv.conf "$folder/etc/"
  for name in proc dev sys; do mount --rbind "/$name" "$folder/$name" && mount --make-rslave "$folder/$name"; done
  mount --bind "$root" "$folder/lodestream"
  # shellcheck disable=SC2064
  trap "umount -R '$folder/lodestream' '$folder/proc' '$folder/dev' '$folder/sys'" EXIT
  chroot "$folder" /lodestream/client/web/build.sh
}

# Downloads the sources of Debian's Draco package, and prints their folder.
draco_source() {  # BUILD
  local at="$1/draco"
  if [[ ! -d "$at/src" ]]; then
    mkdir -p "$at/parts" "$at/lists/partial"
    local uri
    uri="$(grep -rhoE '^(URIs: |deb )[^ ]+' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null | head -1)"
    echo "deb-src ${uri##* } trixie main" > "$at/parts/sources.list"
    local options=(-o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$at/parts" -o "Dir::State::lists=$at/lists")
    (cd "$at" && apt-get "${options[@]}" update && apt-get "${options[@]}" source --download-only --tar-only draco) >&2
    tar -xf "$at"/draco_*.orig.tar.* -C "$at" --strip-components=1
  fi
  echo "$at"
}

# Lists the sources of the module and of the page with their checksums.
list_sources() {  # BUILD
  cd "$root"
  {
    ninja -C "$1" -t deps | grep -oE '(client|common|proto)/[A-Za-z0-9_/.]+\.(h|cpp)$' | grep -v _generated
    echo proto/lodestream.fbs
    git -c safe.directory='*' ls-files client/web/page client/web/module client/web/package-lock.json
  } | sort -u | xargs sha256sum
}

build() {
  local build="$root/build/web" draco
  "$root/docker/install-packages.sh" web
  command -v emcc > /dev/null || fail "there is no emscripten; use Debian 13, or --root FOLDER"
  draco="$(draco_source "$build")"
  emcmake cmake -S "$web/module" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None -DDRACO_SOURCE="$draco"
  ninja -C "$build"
  (cd "$web" && npm ci --no-audit --no-fund && npm run check)
  local dist="$web/dist"
  rm -rf "$dist"
  mkdir -p "$dist"
  install -m 644 "$build/core.js" "$build/core.wasm" "$dist/"
  "$web/page/bundle.sh" "$dist"
  list_sources "$build" > "$web/dist.sha256"
  (cd "$web" && npm test)
}

case "${1:-}" in
  "") build ;;
  --root) build_in "${2:?--root needs a folder}" ;;
  *) fail "usage: client/web/build.sh [--root FOLDER]" ;;
esac
