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

# The driver needs its own TBB, and a program has only one: the system's, which image libraries bring, is older.
rm -rf "$folder/vendors" "$folder/tbb"
mkdir -p "$folder/vendors" "$folder/tbb"
ln -s "$folder"/lib/libtbb.so.12 "$folder/tbb/"
echo "$folder/lib/libintelocl.so" >"$folder/vendors/intel.icd"
if [ "${2:-}" = --beside-pocl ]; then
  cp /etc/OpenCL/vendors/pocl.icd "$folder/vendors/"
fi
printf 'export OCL_ICD_VENDORS=%q\n' "$folder/vendors"
printf 'export LD_LIBRARY_PATH=%q${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}\n' "$folder/tbb"
