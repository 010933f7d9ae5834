#!/usr/bin/env bash
# Installs sections of docker/packages.txt: docker/install-packages.sh run window build test
# Changes nothing, not even apt's lists, if all packages are installed.
# LODESTREAM_PACKAGES=skip skips the check, for systems with other package names.
set -euo pipefail

list="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/packages.txt"

fail() {
  echo "install-packages: $*" >&2
  exit 1
}

packages_of() {  # SECTION...; prints a line per package: its names, separated by '|'
  local section
  for section in "$@"; do
    grep -qx "\[$section\]" "$list" || fail "no section [$section] in $list: it has $(grep -o '^\[.*\]' "$list" | tr '\n' ' ')"
    awk -v wanted="[$section]" '{ sub(/#.*/, ""); gsub(/[ \t]/, "") } /^\[/ { inside = $0 == wanted; next } inside && $0' "$list"
  done
}

# Output is read to its end: under pipefail a reader that stops early makes the writer, and so the check, fail.
is_installed() { [[ " $(dpkg-query -W -f '${db:Status-Status} ' "$1" 2>/dev/null)" == *" installed "* ]]; }

is_offered() { [[ "$(LC_ALL=C apt-cache policy "$1" 2>/dev/null)" =~ Candidate:\ [^\(] ]]; }

is_installed_by_any_name() {  # NAME|NAME...
  local name
  for name in ${1//|/ }; do
    if is_installed "$name"; then return; fi
  done
  return 1
}

names_here() {  # NAME|NAME...; prints the name that apt offers, or the first, for which apt then reports the error
  local names name found
  for names in "$@"; do
    found="${names%%|*}"
    for name in ${names//|/ }; do
      if is_offered "$name"; then
        found="$name"
        break
      fi
    done
    echo "$found"
  done
}

[[ $# -gt 0 ]] || fail "name the sections to install: run, window, build, test, check"
packages="$(packages_of "$@")"
[[ "${LODESTREAM_PACKAGES:-}" != skip ]] || exit 0

by_hand="install what docker/packages.txt lists by hand, then set LODESTREAM_PACKAGES=skip"
command -v dpkg-query >/dev/null || fail "this is not a Debian system: $by_hand"
missing=()
for names in $packages; do
  is_installed_by_any_name "$names" || missing+=("$names")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

command -v apt-get >/dev/null || fail "no apt-get here, and these packages are missing: ${missing[*]}; $by_hand"
as_root=()
if [[ $EUID -ne 0 ]]; then
  command -v sudo >/dev/null || fail "neither root nor sudo; as root, run: apt-get install $(names_here "${missing[@]}" | tr '\n' ' ')"
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -q >&2 || echo "install-packages: apt-get update failed; continuing with the existing lists" >&2
mapfile -t chosen < <(names_here "${missing[@]}")
echo "Installing ${#chosen[@]} packages: ${chosen[*]}" >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${chosen[@]}" >&2 ||
  fail "apt-get could not install all of: ${chosen[*]}; its own message above says why"
