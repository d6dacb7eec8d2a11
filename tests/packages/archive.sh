#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# archive.sh BUILD CPACK: packs the archive of a build, unpacks it in a folder with a blank in its name, and renders; then
# moves it and renders again, through a symbolic link and from another folder. Nothing in it may know where it was built. Ends
# with 77, skipped, where the build has sanitizers.
set -euo pipefail
build=$(realpath "$1")
cpack=$2
source=$(realpath "$(dirname "$0")/../..")
folder=$(mktemp -d -t lucarium-archive-XXXXXX)
trap 'rm -rf "$folder"' EXIT
unset LUCARIUM_TECHNIQUE_PATH LUCARIUM_KERNEL_PATH LD_LIBRARY_PATH

skip() {
  echo "Skipped: $1"
  exit 77
}
fail() {
  echo "failed: $1" >&2
  exit 1
}
grep -q '^LUCARIUM_SANITIZE:STRING=.' "$build/CMakeCache.txt" &&
  skip "what is built with sanitizers loads their libraries, which no package names: it runs where it was built only"

"$cpack" -G TGZ --config "$build/CPackConfig.cmake" -B "$folder/packages" >"$folder/cpack.log" 2>&1 ||
  { cat "$folder/cpack.log" >&2; fail "cpack"; }
(cd "$folder/packages" && sha256sum --quiet -c ./*.sha256) || fail "the checksum beside the archive is another one's"

mkdir "$folder/first place"
tar -xzf "$folder"/packages/*.tar.gz -C "$folder/first place"
tree=$(echo "$folder/first place"/*)
[[ $(basename "$tree") == lucarium-[0-9]* ]] || fail "the archive is not one folder called after its version: $tree"
for file in bin/lucarium share/man/man1/lucarium-render.1 share/bash-completion/completions/lucarium \
  share/doc/lucarium/LICENSE share/doc/lucarium-doc/docs/rendering.md lib/cmake/Lucarium/LucariumConfig.cmake; do
  [ -e "$tree/$file" ] || fail "$file is not in the archive"
done
if grep -rlF "$build" "$tree"; then fail "these files know the build folder $build"; fi
# Pages and comments may name the sources' folders, but not where they lay.
if [[ $source == /*/* ]]; then
  known=$(grep -rlF "$source/" "$tree" || true)
else
  # In a folder of the root, as /lucarium: framework/lucarium/ and ${VARIABLE}/lucarium/ are others.
  known=$(grep -rlE -- "(^|[^[:alnum:]_./})-])$source/" "$tree" || true)
fi
if [ -n "$known" ]; then echo "$known"; fail "these files know the sources' folder $source"; fi

render() {  # PROGRAM FILE
  (cd / && "$1" -q render builtin:cornell -t bundle_exchange --size 32x24 --iterations 1 -o "$2") || fail "rendering by $1"
}
render "$tree/bin/lucarium" "$folder/first.png"
mv "$folder/first place" "$folder/second"
ln -s "$folder/second/$(basename "$tree")/bin/lucarium" "$folder/link"
render "$folder/link" "$folder/second.png"
cmp "$folder/first.png" "$folder/second.png" || fail "the moved program renders another picture"
"$folder/link" techniques --json >"$folder/techniques.json"
if grep '"file":' "$folder/techniques.json" | grep -vF "\"$folder/second/"; then fail "techniques of another folder"; fi
