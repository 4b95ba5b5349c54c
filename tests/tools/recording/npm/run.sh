#!/usr/bin/env bash
# Our MCAP files through MCAP's official reader from the npm registry. Exit code 77 (skipped) where
# node or the registry cannot be had.
# Usage: run.sh SAMPLES-PROGRAM WORK-FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
samples=$1 work=$2
skip() { echo "SKIPPED: MCAP files were NOT checked with the official reader: $*"; exit 77; }
command -v node >/dev/null || skip "no node; install nodejs"
command -v npm >/dev/null || skip "no npm; install npm"
mkdir -p "$work"
cp "$here"/package.json "$here"/package-lock.json "$here"/check_mcap.mjs "$work"
cd "$work"
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts || skip "npm ci failed; is the registry reachable?"
  cp package-lock.json installed-lock.json
fi
rm -rf files && mkdir files
"$samples" files
node check_mcap.mjs files
