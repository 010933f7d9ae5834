#!/usr/bin/env bash
# Every C++ file, known to git or new, is as clang-format 14 would write it, and every script can be run as the documents call
# it; `tests/check_format.sh --fix` makes it so.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=(--dry-run -Werror)
[[ "${1:-}" != --fix ]] || mode=(-i)
files() { git ls-files -z --cached --others --exclude-standard --deduplicate -- "$@"; }

files '*.h' '*.cpp' | xargs -0 --no-run-if-empty clang-format-14 "${mode[@]}"

status=0
while IFS= read -r -d '' script; do
  [[ -f "$script" && ! -x "$script" && "$(head -c 2 "$script" | tr -d '\0')" == '#!' ]] || continue
  if [[ "${1:-}" == --fix ]]; then
    chmod +x "$script"
  else
    echo "$script begins with #! and is not executable: chmod +x $script" >&2
    status=1
  fi
done < <(files)
exit "$status"
