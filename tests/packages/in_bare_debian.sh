#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Run by bare_debian.sh as root inside a bare Debian 12: installs the packages beside this file by apt alone, renders,
# builds a technique against liblucarium-dev, purges them, looks for what remains, and runs the archive.
set -euo pipefail
cd /packages
export LUCARIUM_CACHE_DIR=/packages/cache

fail() {
  echo "failed: $1" >&2
  exit 1
}
quietly() {  # WHAT COMMAND…: its output only where it fails
  local what=$1 begin=$SECONDS
  shift
  "$@" >/packages/log 2>&1 || { tail -n 40 /packages/log >&2; fail "$what"; }
  echo "$what: $((SECONDS - begin)) s"
}
# The picture that the build rendered with the same seed; by another version of the driver up to rounding.
check_render() {  # PROGRAM FILE
  quietly "render by $1" "$1" render builtin:cornell -t path_tracing --size 64x48 --spp 4 -o "$2"
  "$1" diff "$2" built.exr --json >diff.json || fail "diff"
  awk '/"relMSE": [0-9]/ { layers++; if ($2 + 0 > 1e-6) differ = 1 } END { exit !layers || differ }' diff.json ||
    { cat diff.json >&2; fail "$2 is not the picture that the build renders"; }
}

quietly "apt-get update" apt-get update
quietly "install lucarium" apt-get install -y ./lucarium_*.deb
check_render lucarium installed.exr
lucarium -V
lucarium techniques >techniques.txt
for technique in path_tracing bundle_exchange micro_rendering voxel_abuffer bidirectional_vpl virtual_light_field; do
  grep -q "$technique" techniques.txt || fail "the technique $technique is not installed"
done
[ -s /usr/share/man/man1/lucarium-render.1.gz ] || fail "no manual page"
[ -s /usr/share/bash-completion/completions/lucarium ] || fail "no completion"

quietly "install liblucarium-dev and lucarium-doc" apt-get install -y ./liblucarium-dev_*.deb ./lucarium-doc_*.deb
[ -s /usr/share/doc/lucarium-doc/docs/rendering.md ] || fail "no pages"
build_technique() {  # PROGRAM FOLDER: by the commands that new-technique prints
  "$1" new-technique "my_$2" --output "$2" >steps.txt || fail "new-technique"
  grep '^  ' steps.txt >steps.sh
  [ "$(wc -l <steps.sh)" -eq 4 ] || fail "new-technique prints other commands than configure, build, test and render"
  quietly "configure, build, test and render a technique by $1" env PATH="$(dirname "$1"):$PATH" bash -e steps.sh
  grep -q "100% tests passed" log || fail "the technique's tests did not run"
}
build_technique /usr/bin/lucarium of_packages

# What dpkg removes: all that it installed.
cat /var/lib/dpkg/info/{lucarium,liblucarium-dev,lucarium-doc}.list | sort -u >installed.txt
quietly "purge" dpkg -P lucarium-doc liblucarium-dev lucarium
while read -r file; do
  if [ -e "$file" ] && [[ $file == *[lL]ucarium* ]]; then fail "$file remains"; fi
done <installed.txt
remains=$(find / -xdev -ipath '*lucarium*' -not -path '/packages/*')
[ -z "$remains" ] || fail "these remain: $remains"
if ldconfig -p | grep -i lucarium; then fail "the loader still knows the library"; fi

# The archive runs on what the packages needed, wherever it lies.
mkdir "/opt/a folder"
tar -xzf ./*.tar.gz -C "/opt/a folder"
mv "/opt/a folder" /opt/moved
tree=$(echo /opt/moved/*)
check_render "$tree/bin/lucarium" archive.exr
build_technique "$tree/bin/lucarium" of_archive
