#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/drivers/intel.sh FOLDER [--beside-pocl]: puts Intel's OpenCL runtime for CPUs into FOLDER (a Python environment,
# some 800 MB, once) and prints the shell commands by which programs use it instead of the drivers of the machine, or
# beside PoCL: eval "$(tools/drivers/intel.sh build/drivers/intel)". Nothing outside of FOLDER is changed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=${1:?tools/drivers/intel.sh needs a folder}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

# The stamp holds the list that was installed.
if ! cmp -s "$here/intel.txt" "$folder/installed.txt"; then
  echo "Installing Intel's OpenCL runtime into $folder" >&2
  python3 -m venv "$folder" >&2 || {
    echo "lucarium: python3 cannot make a virtual environment; apt-get install python3-venv" >&2
    exit 1
  }
  "$folder/bin/pip" install --quiet --disable-pip-version-check -r "$here/intel.txt" >&2 || {
    echo "lucarium: pip cannot install $here/intel.txt; is PyPI reachable?" >&2
    exit 1
  }
  cp "$here/intel.txt" "$folder/installed.txt"
fi

# Replaced as a whole: programs may use these folders at this moment.
vendors=$folder/vendors
[ "${2:-}" = --beside-pocl ] && vendors=$folder/vendors_beside_pocl
mkdir -p "$vendors" "$folder/tbb"
put() { cat >"$1.$$" && mv "$1.$$" "$1"; }
echo "$folder/lib/libintelocl.so" | put "$vendors/intel.icd"
[ "${2:-}" = --beside-pocl ] && put "$vendors/pocl.icd" </etc/OpenCL/vendors/pocl.icd
# The driver needs its own TBB, and a program has only one: the system's, which image libraries bring, is older.
ln -sfn "$folder/lib/libtbb.so.12" "$folder/tbb/libtbb.so.12"
printf 'export OCL_ICD_VENDORS=%q\n' "$vendors"
printf 'export LD_LIBRARY_PATH=%q${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}\n' "$folder/tbb"
