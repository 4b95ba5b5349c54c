#!/usr/bin/env bash
# Makes the packages of a build that is complete, and looks at them: lintian, the host tools unpacked into an empty
# folder, the controller installed in a fresh Debian. Exit code 77: the installation was skipped, the rest is good.
# usage: package_test.sh BUILD-FOLDER SANSO-EMULATOR
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$1 emulator=$2
work=$build/package-test
fail() { echo "FAILED: $*"; exit 1; }
rm -rf "$work/debs" "$work/host"
mkdir -p "$work/debs" "$work/host"
cpack --config "$build/CPackConfig.cmake" -B "$work/debs" > "$work/cpack.log" 2>&1 || { cat "$work/cpack.log"; exit 1; }
firmware=$(ls "$work"/debs/sanso-firmware_*.deb)
host=$(ls "$work"/debs/sanso_*.deb)

dpkg-deb -x "$host" "$work/host"
for motion in jog stand walk_forward; do
  grep -q "^ *$motion\b" <(cd / && "$work/host/usr/bin/sanso" motions) || fail "the unpacked program does not know $motion"
done
alone=$(mktemp -d)
cp "$work/host/usr/bin/sanso" "$alone/"
! (cd / && "$alone/sanso" motions) > "$alone/said" 2>&1 || fail "taken elsewhere, the program looks where it was built"
grep -q SANSO_MOTIONS "$alone/said" || fail "a program without motions does not say what to do: $(cat "$alone/said")"
rm -r "$alone"
for file in sanso/layouts/foxglove.json sanso/worlds/lab.toml bash-completion/completions/sanso man/man1/sanso.1.gz; do
  [[ -e $work/host/usr/share/$file ]] || fail "$file is not in the package"
done
expected=$work/host/usr/share/sanso/motions
[[ $(ls "$expected") == $(ls "$here/../../host/motion/library") ]] || fail "not all motions are in the package"
! grep -aq "CMakeFiles" "$work/host/usr/bin/sanso-emulator" || fail "the emulator is not stripped"

if command -v lintian > /dev/null; then
  lintian --fail-on error --suppress-tags "$(grep -v '^#' "$here/lintian-suppress" | paste -sd,)" "$firmware" "$host" ||
    fail "lintian complains"
else
  echo "SKIPPED: no lintian"
fi
exec python3 "$here/install_test.py" "$firmware" "$emulator" "$work"
