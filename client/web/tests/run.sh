#!/usr/bin/env bash
# Runs the tests of the page's parts that need no browser: client/web/tests/run.sh. Needs npm ci, esbuild and node.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")"
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
esbuild ./*_test.mjs --bundle --platform=node --format=esm --outdir="$out" --out-extension:.js=.mjs --log-level=warning
node --test "$out"/*.mjs
