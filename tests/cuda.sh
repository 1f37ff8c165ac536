#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: cuda.sh ROOT NVCC
# Compiles all headers of kernels/ as CUDA, and the .cu files of tests/, which instantiate kernels on the device. That each header
# includes what it needs is shown by malha_headers.
# Exits 77 (skipped) where there is no nvcc.
set -euo pipefail
root=${1:?usage: cuda.sh ROOT NVCC}
nvcc=${2-}
if ! command -v "$nvcc" >/dev/null; then
  echo "skipped: no nvcc"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cd "$root"
all=$scratch/all_headers.cu
find kernels -name '*.h' | sort | sed 's/.*/#include "&"/' >"$all"
[[ -s "$all" ]] || { echo "no headers in $root/kernels"; exit 1; }
sources=("$all")
while IFS= read -r source; do sources+=("$source"); done < <(find tests -name '*.cu')

compile() {  # nothing is run: so up to the device's assembler, which takes most of the time and refuses nothing of ours
  "$nvcc" -std=c++20 -x cu -ptx -Xcicc -O0 -Werror all-warnings \
    -I "$root" -I "$root/host" "$1" -o "$scratch/$(basename "$1").ptx" || { echo "not CUDA: $(basename "$1")"; return 1; }
}
export -f compile
export nvcc root scratch
# shellcheck disable=SC2016  # expanded by the inner bash
printf '%s\0' "${sources[@]}" | xargs -0 -n 1 -P 2 bash -c 'compile "$1"' _
printf '%d files compiled as CUDA\n' "${#sources[@]}"
