#!/usr/bin/env bash
# Installs sections of docker/packages.txt: docker/install-packages.sh run window build test
# Changes nothing, not even apt's lists, if all packages are installed.
# --plan before the sections only prints what it would install, with sizes.
# LODESTREAM_PACKAGES=skip skips the check, for systems with other package names.
set -euo pipefail

folder="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
list="$folder/packages.txt"
apt=()  # options that tell apt where its lists are

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

# Read the output to its end: under pipefail, a reader that stops early makes the writer, and so the check,
# fail.
is_installed() { [[ " $(dpkg-query -W -f '${db:Status-Status} ' "$1" 2>/dev/null)" == *" installed "* ]]; }

is_offered() { [[ "$(LC_ALL=C apt-cache "${apt[@]}" policy "$1" 2>/dev/null)" =~ Candidate:\ [^\(] ]]; }

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
    [[ "$names" == *"|"* ]] || names=""
    for name in ${names//|/ }; do
      if is_offered "$name"; then
        found="$name"
        break
      fi
    done
    echo "$found"
  done
}

# Ends the script if apt-get update reached no server at all.
require_network() {  # OUTPUT of apt-get update
  local why
  [[ "$1" == *Err:* ]] || return 0
  ! grep -qE '^(Get|Hit):' <<<"$1" || return 0
  why="$(awk '/^Err:/ { getline; sub(/^ +/, ""); print; exit }' <<<"$1")"
  fail "no network: apt reaches no package mirror ($why), and packages are missing: ${#missing[@]};" \
    "connect this machine and try again"
}

print_uris() {  # prints what apt would load, and the sizes; fails if apt's lists do not have all packages
  local chosen
  mapfile -t chosen < <(names_here "${missing[@]}")
  LC_ALL=C apt-get "${apt[@]}" install --print-uris -y --no-install-recommends "${chosen[@]}" 2>/dev/null
}

# Prints how many packages an installation gets, their sizes, and as whom it runs. apt writes only to a temporary folder.
# If its lists do not have all packages, because they are empty or old, it loads new ones into that folder.
print_plan() {
  local said number download disk
  temporary="$(mktemp -d)"
  trap 'rm -rf "$temporary"' EXIT
  mkdir "$temporary/lists"
  cat >"$temporary/apt.conf" <<EOF
Dir::State::lists "$temporary/lists";
Dir::Cache::pkgcache "$temporary/pkgcache.bin";
Dir::Cache::srcpkgcache "$temporary/srcpkgcache.bin";
APT::Sandbox::User "root";
Acquire::Languages "none";
Acquire::Retries "0";
Acquire::http::Timeout "10";
Acquire::https::Timeout "10";
EOF
  if said="$(print_uris)"; then
    echo '#clear Acquire::IndexTargets;' >>"$temporary/apt.conf"  # loads only the mirrors' dates
  else
    apt=(-c "$temporary/apt.conf")
  fi
  require_network "$(LC_ALL=C apt-get -c "$temporary/apt.conf" update -q 2>&1)"
  [[ ${#apt[@]} -eq 0 ]] || said="$(print_uris)" || true

  number="$(awk '/ newly installed/ { print $1 + $3 }' <<<"$said")"
  download="$(awk '/^Need to get / { sub(/\/.*/, ""); print $4, $5 }' <<<"$said")"
  disk="$(awk '/^After this operation, .* used/ { print $4, $5 }' <<<"$said")"
  if [[ -n "$number" && -n "$download" ]]; then
    echo "$number packages ($download to download, ${disk:-no space} on disk) $as_whom"
  else
    echo "${#missing[@]} packages and those that they need (sizes unknown) $as_whom"
  fi
}

# Loads apt's lists and installs what is missing.
install_missing() {
  local said chosen
  said="$("${as_root[@]}" env LC_ALL=C apt-get update -q 2>&1)" || {
    require_network "$said"
    echo "${said:+$said$'\n'}install-packages: apt-get update failed; continuing with the existing lists" >&2
  }
  require_network "$said"
  mapfile -t chosen < <(names_here "${missing[@]}")
  echo "Installing ${#chosen[@]} packages: ${chosen[*]}" >&2
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${chosen[@]}" >&2 ||
    fail "apt-get could not install all of: ${chosen[*]}; its own message above says why"
}

act=install_missing
if [[ "${1:-}" == --plan ]]; then
  act=print_plan
  shift
fi
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
as_whom="as root"
if [[ $EUID -ne 0 ]]; then
  command -v sudo >/dev/null ||
    fail "neither root nor sudo, and packages are missing: ${#missing[@]}; as root, run: $folder/install-packages.sh $*"
  as_root=(sudo)
  as_whom="with sudo"
fi
"$act"
