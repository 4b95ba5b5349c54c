#!/usr/bin/env bash
# The live page, the one of a watcher, the replay of a report, films, the preview of a motion and the
# robot of a diagnosis in headless chromium;
# screenshots stay in the work folder. Exit code 77 (skipped) where node, the registry or chromium
# cannot be had.
# Usage: run.sh SANSO WORK-FOLDER MECHANISM-SAMPLES FIRMWARE EMULATOR
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
sanso=$1 samples=$3 firmware=$4 emulator=$5
source "$here/../../../support/with_npm.sh" "$here" "$2" "the page was NOT looked at in a browser"
command -v chromium >/dev/null || skip "no chromium"
rm -rf live replay watch preview && mkdir -p screenshots mechanism
"$samples" mechanism
node check_diagnosis.mjs mechanism screenshots
node check_live.mjs "$sanso" live screenshots
node check_replay.mjs "$sanso" replay screenshots
node check_film.mjs "$sanso" replay screenshots
node check_preview.mjs "$sanso" preview screenshots
node check_watch.mjs "$sanso" "$firmware" "$emulator" replay watch screenshots
