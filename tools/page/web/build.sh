#!/usr/bin/env bash
# Fetches what package-lock.json names, bundles the page and writes it as C++. Where npm or the
# registry cannot be had it writes an empty bundle and says so: everything else still builds.
# Usage: build.sh WORK-FOLDER OUT.cpp
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$1 out=$2
without() {
  echo "the page that shows the robot is NOT built: $*. To try again: rm $out and build." >&2
  cat > "$out" <<'EMPTY'
// Written by tools/page/web/build.sh: npm could not be had.
#include "tools/page/embedded/bundle.h"

const sanso::page::Bundle& sanso::page::bundle() {
  static const Bundle kNone;
  return kNone;
}
EMPTY
  exit 0
}
command -v node >/dev/null || without "no node; install nodejs"
command -v npm >/dev/null || without "no npm; install npm"
mkdir -p "$work"
cp -r "$here"/{package.json,package-lock.json,.npmrc,index.html,build.mjs,src} "$work"
cd "$work"
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts >npm.log 2>&1 || without "npm ci failed, see $work/npm.log"
  cp package-lock.json installed-lock.json
fi
node build.mjs "$out"
