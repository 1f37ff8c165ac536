#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: instructions.sh OBJDUMP LIBRARY ANYWHERE COMPILER
# Refuses hardware gathers (slower than loads and transposes; clang 16 cannot be told so), fused multiply-adds (other
# bits) and, with ANYWHERE ON (a build that is to run on any x86-64), AVX instructions outside the functions `run`, which
# alone are called by what the CPU has. COMPILER: CMake's name of it.
# Exits 77 (skipped) where there is no objdump, or on another architecture.
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
  # VEX and EVEX; verr and verw are older.
  $2 ~ /^v/ && $2 !~ /^ver/ && anywhere == "ON" && function_name !~ /malha::run</ { refuse() }
  END {
    if (!solver) { print "no function malha::run in the library: nothing was checked"; ++faults }
    printf "%d faults\n", faults
    exit faults > 0
  }'
