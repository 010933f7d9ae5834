#!/usr/bin/env bash
# Installs the sections of docker/packages.txt that are named: docker/install-packages.sh run build test
# Touches nothing, not even apt's lists, where all packages are there already.
# LODESTREAM_PACKAGES=skip trusts that they are (systems other than Debian 12, where they bear other names).
set -euo pipefail

list="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/packages.txt"

fail() {
  echo "install-packages: $*" >&2
  exit 1
}

packages_of() {  # SECTION...
  local section
  for section in "$@"; do
    grep -qx "\[$section\]" "$list" || fail "no section [$section] in $list: it has $(grep -o '^\[.*\]' "$list" | tr '\n' ' ')"
    awk -v wanted="[$section]" '{ sub(/#.*/, ""); gsub(/[ \t]/, "") } /^\[/ { inside = $0 == wanted; next } inside && $0' "$list"
  done
}

is_installed() { dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed; }

[[ $# -gt 0 ]] || fail "name the sections to install: run, build, test"
names="$(packages_of "$@")"
[[ "${LODESTREAM_PACKAGES:-}" != skip ]] || exit 0

by_hand="install what docker/packages.txt lists by hand, then set LODESTREAM_PACKAGES=skip"
command -v dpkg-query >/dev/null || fail "this is no Debian system: $by_hand"
missing=()
for name in $names; do
  is_installed "$name" || missing+=("$name")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

command -v apt-get >/dev/null || fail "no apt-get here, and these packages are missing: ${missing[*]}; $by_hand"
as_root=()
if [[ $EUID -ne 0 ]]; then
  command -v sudo >/dev/null || fail "neither root nor sudo; as root, run: apt-get install ${missing[*]}"
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}" >&2
"${as_root[@]}" apt-get update -q >&2 || echo "install-packages: apt-get update failed; going on with the lists that are there" >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >&2 ||
  fail "apt-get could not install all of: ${missing[*]}; its own message above says why"
