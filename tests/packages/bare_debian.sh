#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# bare_debian.sh BUILD CPACK: makes the Debian packages of a build, has lintian read them, and installs them by apt into a
# Debian 12 that debootstrap has just made, where nothing else is. What is then tried there is in_bare_debian.sh. Ends
# with 77, skipped, where debootstrap, lintian, root or a mirror is absent; LUCARIUM_DEBIAN_MIRROR names another mirror.
set -euo pipefail
build=$(realpath "$1")
cpack=$2
here=$(realpath "$(dirname "$0")")
mirror=${LUCARIUM_DEBIAN_MIRROR:-http://deb.debian.org/debian}

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
for tool in debootstrap lintian dpkg-shlibdeps unshare; do
  command -v $tool >/dev/null || skip "$tool is not installed"
done
[ "$(id -u)" -eq 0 ] || skip "only root makes a root folder"
unshare --mount true 2>/dev/null || skip "no mount namespaces here"

folder=$(mktemp -d -t lucarium-debian-XXXXXX)
trap 'rm -rf --one-file-system "$folder"' EXIT

"$cpack" -G "DEB;TGZ" --config "$build/CPackConfig.cmake" -B "$folder/packages" >"$folder/cpack.log" 2>&1 ||
  { cat "$folder/cpack.log" >&2; fail "cpack"; }
lintian --allow-root --fail-on error "$folder"/packages/*.deb || fail "lintian finds errors"
echo "lintian: no errors"

debootstrap --variant=minbase bookworm "$folder/root" "$mirror" >"$folder/debootstrap.log" 2>&1 ||
  { tail -n 5 "$folder/debootstrap.log"; skip "debootstrap cannot make Debian 12 from $mirror"; }
mkdir "$folder/root/packages"
cp "$folder"/packages/*.deb "$folder"/packages/*.tar.gz "$here/in_bare_debian.sh" "$folder/root/packages"

# The same pictures as by the build itself.
"$build/bin/lucarium" -q render builtin:cornell -t path_tracing --size 64x48 --spp 4 -o "$folder/root/packages/built.exr"

# Mounts end with the namespace, before the folder is removed.
unshare --mount --pid --fork bash -c '
  mount -t proc proc "$0/proc" && mount --rbind /sys "$0/sys" && mount --rbind /dev "$0/dev" &&
  exec chroot "$0" /usr/bin/env -i PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive bash /packages/in_bare_debian.sh' "$folder/root" || fail "in the bare Debian"
