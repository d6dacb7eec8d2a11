#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/install_packages.sh [build]: installs what tools/packages.txt lists and is not there yet; with "build" without
# what only running the tests needs. Asks nothing, works as root or with sudo, and says what is missing where there is no
# apt. Does nothing when everything is installed. What only tests need may not exist: Debian 13 has no oclgrind.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
list=$(cat "$here/packages.txt")
for_tests=${list#*# running the tests only}
[ "${1:-}" = build ] && list=${list%%# running the tests only*}
mapfile -t packages < <(sed 's/#.*//; s/[[:space:]]//g; /^$/d' <<<"$list")

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  [ "${LUCARIUM_SKIP_PACKAGES:-}" = 1 ] && exit 0
  echo "lucarium: this system has no apt. Install by its own means what these Debian 12 packages hold:" >&2
  echo "  ${packages[*]}" >&2
  echo "then run again with LUCARIUM_SKIP_PACKAGES=1." >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [ "$status" = "install ok installed" ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "lucarium: packages are missing and there is no sudo; as root run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "Installing ${#missing[@]} packages: ${missing[*]}"
only_for_tests() { awk -v name="$1" '$1 == name { found = 1 } END { exit !found }' <<<"$for_tests"; }
# A fresh machine has no package index, an old one may name versions that are gone.
updated=yes
"${as_root[@]}" apt-get update -qq </dev/null || {
  echo "lucarium: apt-get update failed; using the index at hand" >&2
  updated=no
}
found=()
for package in "${missing[@]}"; do
  if [ $updated = no ] || apt-cache show "$package" >/dev/null 2>&1 || ! only_for_tests "$package"; then
    found+=("$package")
  else
    echo "lucarium: this system has no package $package; tests that need it are skipped" >&2
  fi
done
[ ${#found[@]} -eq 0 ] && exit 0
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${found[@]}" </dev/null >/dev/null
