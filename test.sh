#!/usr/bin/env bash
# Builds everything and runs the tests: ./test.sh [--all] [OPTIONS of ctest]
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$root"

usage() {
  cat <<'EOF'
usage: ./test.sh [--all] [OPTIONS]

Installs missing packages, builds the dev preset and runs the unit and integration tests; --all runs the slow
ones too. Other options go to ctest: ./test.sh -R store, ./test.sh -L unit. Tests of scans read the folder
LODESTREAM_TEST_DATA and are skipped without it.
EOF
}

preset=dev
case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
  --all)
    preset=dev-all
    shift
    ;;
esac

docker/install-packages.sh run window build test
started=$SECONDS
rm -f build/dev/test.log
first=()
[[ -f build/dev/CMakeCache.txt ]] || first=(-DCMAKE_UNITY_BUILD=ON)  # halves a whole build
cmake --preset dev "${first[@]}"
cmake --build --preset dev
built=$SECONDS

status=0
ctest --preset "$preset" --parallel "$(nproc)" "$@" 2>&1 | tee build/dev/test.log || status=$?
echo "test.sh: built in $((built - started)) s, tested in $((SECONDS - built)) s; the log is in build/dev/test.log"
grep -E '^[0-9]+% tests passed' build/dev/test.log || echo "test.sh: ctest ran no tests" >&2
exit "$status"
