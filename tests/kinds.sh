#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: kinds.sh ROOT COMPILER
# A constraint kind that lacks a part of the contract (kernels/projection/constraint_kind.h) does not compile, and the compiler
# names the part.
set -euo pipefail
root=${1:?usage: kinds.sh ROOT COMPILER}
compiler=${2:?usage: kinds.sh ROOT COMPILER}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cat >"$scratch/kind.cpp" <<'CPP'
#include "kernels/projection/constraint_kind.h"
using namespace malha;
struct Spring {
  NAME ELEMENT PARTICLES INEQUALITY PARAMETER STRENGTH MODULUS FILTERED NUMBERS REST EVALUATE
};
template <ConstraintKind K> struct Registered {};
Registered<Spring> registered;
CPP

declare -A part=(
  [NAME]='static constexpr const char* name = "spring";'
  [ELEMENT]='static constexpr Element element = Element::Edges;'
  [PARTICLES]='static constexpr int particles = 2;'
  [INEQUALITY]='static constexpr bool inequality = false;'
  [PARAMETER]='static constexpr Parameter parameter{"rest_scale", 1, 0, true};'
  [STRENGTH]='static constexpr Strength strength{true, nullptr, nullptr};'
  [MODULUS]=''
  [FILTERED]='static constexpr Filtered filtered = Filtered::Spring;'
  [NUMBERS]='static constexpr int rest_values = 1;'
  [REST]='template <class S> static void rest(const Vector3<S> (&)[2], S, S (&)[1]);'
  [EVALUATE]='template <class S, class M> static S evaluate(const Vector3<S> (&)[2], const S*, const M&, Vector3<S> (&)[2], S&);'
)
compile() {  # compile PART VALUE: with that part so, and all others as they should be
  local name flags=()
  for name in "${!part[@]}"; do
    if [[ $name == "$1" ]]; then flags+=("-D$name=$2"); else flags+=("-D$name=${part[$name]}"); fi
  done
  "$compiler" -std=c++20 -fopenmp -fsyntax-only -w -I "$root" "${flags[@]}" "$scratch/kind.cpp" >"$scratch/said" 2>&1
}

faults=0
compile NONE '' || { echo "the whole kind does not compile:"; cat "$scratch/said"; faults=1; }
refused() {  # refused PART VALUE CONCEPT
  if compile "$1" "$2"; then
    echo "compiled with '$2' for $1"
    faults=$((faults + 1))
  elif ! grep -q "$3" "$scratch/said"; then
    echo "with '$2' for $1 the compiler did not name $3:"
    head -n 5 "$scratch/said"
    faults=$((faults + 1))
  fi
}
refused NAME '' HasName
refused ELEMENT '' HasElement
refused ELEMENT 'static constexpr Element element = Element::Triangles;' HasElement
refused INEQUALITY '' DeclaresInequality
refused PARAMETER '' HasParameter
refused STRENGTH '' HasStrength
refused STRENGTH 'static constexpr Strength strength{false, "young_modulus", "Pa"};' ConvertsModulus
refused FILTERED '' DeclaresFiltered
refused FILTERED 'static constexpr Filtered filtered = Filtered::Stencil;' HasStencilIfFiltered
refused INEQUALITY 'static constexpr bool inequality = true;' DeclaresFiltered
refused NUMBERS '' HasRestValues
refused REST '' HasRestValues
refused EVALUATE '' HasEvaluate
refused EVALUATE 'static float evaluate(const Vector3<float> (&)[2], const float*, bool, Vector3<float> (&)[2], float&);' HasEvaluate
printf '%d faults\n' "$faults"
((faults == 0))
