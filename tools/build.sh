#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/build.sh [PRESET [TARGET ...]]: installs missing packages, configures and builds build/PRESET (default: release),
# all of it or the given targets (then without the packages that only running the tests needs).
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
preset=${1:-release}
shift $(($# > 0))
"$root/tools/install_packages.sh" ${1:+build}
cd "$root"
mkdir -p build
log=build/$preset-configure.log
if ! cmake --preset "$preset" -Wno-dev >"$log" 2>&1; then
  cat "$log" >&2
  echo "lucarium: configuring failed (above); tools/packages.txt lists what is needed" >&2
  exit 1
fi
echo "Building build/$preset"
cmake --build --preset "$preset" ${1:+--target "$@"}
