#!/usr/bin/env bash
# A real trial as MCAP, read by the format's own npm reader; its schemas against ROS 2's definitions; the shipped layouts
# against its topics. Exit code 77 (skipped) where node or the registry cannot be had.
# Usage: run.sh SANSO WORK-FOLDER LAYOUTS-FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
sanso=$1 layouts=$3
source "$here/../../../support/with_npm.sh" "$here" "$2" "MCAP files were NOT read by another reader"
rm -rf session
"$sanso" learn --motion stand --iterations 1 --out session >learn.log || { cat learn.log; exit 1; }
"$sanso" export session --mcap trial.mcap
node check_mcap.mjs trial.mcap "$layouts"
