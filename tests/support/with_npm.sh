# Sourced by tests that drive npm packages: copies a folder into a work folder, installs what its
# lock file names, goes there. Ends with 77 (skipped, with a word) where that cannot be had.
# Usage: source with_npm.sh SOURCE-FOLDER WORK-FOLDER WHAT-IS-NOT-TESTED-OTHERWISE
skip() { echo "SKIPPED: $what_is_left: $*"; exit 77; }
what_is_left=$3
command -v node >/dev/null || skip "no node; install nodejs"
command -v npm >/dev/null || skip "no npm; install npm"
mkdir -p "$2"
cp "$1"/{package.json,package-lock.json,.npmrc,*.mjs} "$2"
cd "$2"
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts || skip "npm ci failed; is the registry reachable?"
  cp package-lock.json installed-lock.json
fi
