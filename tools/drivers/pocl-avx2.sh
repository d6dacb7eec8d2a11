#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/drivers/pocl-avx2.sh FOLDER: compiles a library into FOLDER and prints the shell commands by which PoCL treats a
# processor with AVX-512 as one that has AVX2 alone: eval "$(tools/drivers/pocl-avx2.sh build/drivers/pocl-avx2)".
# Needs the headers of the LLVM that PoCL was built with (Debian 12: llvm-15-dev).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=${1:?tools/drivers/pocl-avx2.sh needs a folder}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
if ! command -v llvm-config-15 >/dev/null; then
  echo "lucarium: the headers of LLVM 15 are missing; apt-get install llvm-15-dev" >&2
  exit 1
fi
# shellcheck disable=SC2046  # flags are words
c++ -std=c++17 -O1 -fPIC -shared $(llvm-config-15 --cppflags) "$here/pocl_as_avx2.cpp" -o "$folder/pocl_as_avx2.so" -ldl
printf 'export LD_PRELOAD=%q${LD_PRELOAD:+:$LD_PRELOAD}\n' "$folder/pocl_as_avx2.so"
