#!/usr/bin/env bash
# Checks that every C++ file, tracked or new, is formatted by clang-format 14 and every script is executable.
# tests/check_format.sh --fix mends both.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=(--dry-run -Werror)
[[ "${1:-}" != --fix ]] || mode=(-i)
files() { git ls-files -z --cached --others --exclude-standard --deduplicate -- "$@"; }

files '*.h' '*.cpp' | xargs -0 --no-run-if-empty clang-format-14 "${mode[@]}"

status=0
while IFS= read -r script; do
  [[ ! -x "$script" ]] || continue
  if [[ "${1:-}" == --fix ]]; then
    chmod +x "$script"
  else
    echo "$script begins with #! and is not executable: chmod +x $script" >&2
    status=1
  fi
done < <(files | xargs -0 awk 'FNR == 1 { if (/^#!/) print FILENAME; nextfile }' 2>/dev/null)
exit "$status"
