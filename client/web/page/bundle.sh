#!/usr/bin/env bash
# Bundles the page: client/web/page/bundle.sh OUT_DIR writes index.html, style.css, app.js and worker.js.
# Needs three.js in client/web/node_modules (npm ci) and esbuild.
set -euo pipefail

out="${1:?usage: bundle.sh OUT_DIR}"
page="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
mkdir -p "$out"
out="$(cd "$out" && pwd)"

cd "$page"
options=(--bundle --format=esm --target=es2022 --minify --legal-comments=eof --charset=utf8 --log-level=warning)
esbuild main.ts "${options[@]}" --outfile="$out/app.js"
esbuild decode_worker.ts "${options[@]}" --outfile="$out/worker.js"
cp index.html style.css "$out/"
