#!/usr/bin/env bash
# Every C++ file, known to git or new, is as clang-format 14 would write it; `tests/check_format.sh --fix` makes it so.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=(--dry-run -Werror)
[[ "${1:-}" != --fix ]] || mode=(-i)
git ls-files -z --cached --others --exclude-standard --deduplicate -- '*.h' '*.cpp' | xargs -0 --no-run-if-empty clang-format-14 "${mode[@]}"
