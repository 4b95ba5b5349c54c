#!/usr/bin/env bash
# The replay of a report in headless chromium. Exit code 77 (skipped) where node, the registry
# or chromium cannot be had.
# Usage: run.sh SANSO WORK-FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
sanso=$1 work=$2
skip() { echo "SKIPPED: the page was NOT looked at in a browser: $*"; exit 77; }
command -v node >/dev/null || skip "no node; install nodejs"
command -v npm >/dev/null || skip "no npm; install npm"
command -v chromium >/dev/null || skip "no chromium"
mkdir -p "$work"
cp "$here"/{package.json,package-lock.json,.npmrc,*.mjs} "$work"
cd "$work"
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts || skip "npm ci failed; is the registry reachable?"
  cp package-lock.json installed-lock.json
fi
rm -rf replay && mkdir -p screenshots
node check_replay.mjs "$sanso" replay screenshots
