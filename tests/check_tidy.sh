#!/usr/bin/env bash
# clang-tidy 14 over the sources of the programs, by .clang-tidy: tests/check_tidy.sh [BUILD] [FILE...]
# BUILD (build/dev) is a configured build folder; its generated headers must be there, so build before.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
build="${1:-build/dev}"
[[ $# -eq 0 ]] || shift
if [[ ! -f "$build/compile_commands.json" ]]; then
  echo "check_tidy: no $build/compile_commands.json; run: cmake --preset dev && cmake --build --preset dev" >&2
  exit 1
fi

# clang-tidy reads no headers that g++ precompiled: each file must include what it uses.
commands="$(mktemp -d)"
trap 'rm -r "$commands"' EXIT
sed -E 's/ -Winvalid-pch -include [^ ]+//' "$build/compile_commands.json" >"$commands/compile_commands.json"

files=("$@")
if [[ ${#files[@]} -eq 0 ]]; then
  mapfile -t files < <(git ls-files --cached --others --exclude-standard --deduplicate -- 'common/*.cpp' 'proto/*.cpp' 'server/*.cpp' 'client/*.cpp' \
    ':!client/embed/examples')  # compiled against an installed tree
fi

check_one() {  # clang-tidy's own chatter only where it has something to say
  local said
  if ! said="$(clang-tidy-14 -p "$1" --quiet "$2" 2>&1)"; then
    grep -vE '^[0-9]+ warnings? (generated|treated)' <<<"$said"
    return 1
  fi
}
export -f check_one
echo "tidy: ${#files[@]} files"
printf '%s\0' "${files[@]}" | xargs -0 -P "$(nproc)" -I{} bash -c 'check_one "$@"' check_one "$commands" {}
