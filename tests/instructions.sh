#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: instructions.sh OBJDUMP LIBRARY ANYWHERE COMPILER
# Refuses hardware gathers (slower than loads and transposes; clang 16 has no option against them), fused multiply-adds
# (they change bits) and, with ANYWHERE ON (a build for any x86-64), AVX instructions outside the functions `run`, which
# are only called if the CPU supports them. COMPILER: CMake's name of the compiler.
# Exits 77 (skipped) if there is no objdump, and on other architectures.
set -euo pipefail
objdump=${1-}
library=${2:?usage: instructions.sh OBJDUMP LIBRARY ANYWHERE COMPILER}
anywhere=${3:?usage: instructions.sh OBJDUMP LIBRARY ANYWHERE COMPILER}
compiler=${4:?usage: instructions.sh OBJDUMP LIBRARY ANYWHERE COMPILER}
if ! command -v "$objdump" >/dev/null || [[ $(uname -m) != x86_64 ]]; then
  echo "skipped: no objdump, or not x86-64"
  exit 77
fi

"$objdump" -dC --no-show-raw-insn "$library" | awk -F '\t' -v anywhere="$anywhere" -v compiler="$compiler" '
  function refuse() { if (!told[function_name]++) { print function_name " refused: " $2; ++faults } }
  /^[0-9a-f]+ <.*>:$/ { function_name = $0; solver = solver || /malha::run</ }
  NF < 2 { next }
  ($2 ~ /^vp?gather/ && compiler == "GNU") || $2 ~ /^vfn?m(add|sub)/ { refuse() }
  # VEX and EVEX instructions begin with v; so do verr and verw, which are older.
  $2 ~ /^v/ && $2 !~ /^ver/ && anywhere == "ON" && function_name !~ /malha::run</ { refuse() }
  END {
    if (!solver) { print "no function malha::run in the library: nothing was checked"; ++faults }
    printf "%d faults\n", faults
    exit faults > 0
  }'
