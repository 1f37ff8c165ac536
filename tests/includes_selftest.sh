#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Proves on made-up trees that includes.sh refuses what it must, and only that.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

# fresh: a tree that obeys.
fresh() {
  rm -rf "${root:?}"/*
  mkdir -p "$root"/{kernels/simd,kernels/constraints,host/malha,host/mesh,host/solver,tools,tests/consumer}
  printf '#pragma once\n#include <math.h>\n' >"$root/kernels/simd/vec.h"
  printf '#include "kernels/simd/vec.h"\n' >"$root/kernels/constraints/distance.h"
  printf '#include <vector>\n' >"$root/host/malha/mesh.h"
  printf '#include "malha/mesh.h"\n' >"$root/host/malha/scene.h"
  printf '#include <memory>\n#include "malha/scene.h"\n' >"$root/host/malha/simulation.h"
  printf '#include <Eigen/Core>\n#include "malha/mesh.h"\n' >"$root/host/mesh/topology.h"
  printf '#include "host/mesh/topology.h"\n#include "kernels/simd/vec.h"\n' >"$root/host/solver/solver.h"
  printf '#include "malha/mesh.h"\n#include "kernels/simd/vec.h"\n#include <Eigen/Dense>\n' >"$root/host/mesh/mesh.cpp"
  printf '#include "malha/mesh.h"\n' >"$root/tools/malha.cpp"
  printf '#include "tools/malha.cpp"\n#include <gtest/gtest.h>\n' >"$root/tests/mesh_test.cpp"
}

fresh
"$here/includes.sh" "$root" >/dev/null || { echo "refused a tree that obeys"; exit 1; }

cases=0
# refuses FILE LINE: with LINE at the end of FILE, the check fails and names the file and its line.
refuses() {
  fresh
  printf '%s\n' "$2" >>"$root/$1"
  local line said
  line=$(wc -l <"$root/$1")
  if said=$("$here/includes.sh" "$root") || ! grep -q "^$1:$line:" <<<"$said"; then
    printf 'let through in %s: %s\n%s\n' "$1" "$2" "$said"
    exit 1
  fi
  cases=$((cases + 1))
}

refuses kernels/simd/vec.h '#include "malha/mesh.h"'
refuses kernels/simd/vec.h '#include "tools/malha.cpp"'
refuses kernels/simd/vec.h '#include "tests/mesh_test.cpp"'
refuses kernels/simd/vec.h '#include "constraints/distance.h"'
refuses kernels/simd/vec.h '#include "kernels/constraints/distance.h"'
refuses kernels/constraints/distance.h '  #  include   <vector>'
for header in array memory functional iostream algorithm string unordered_map Eigen/Dense Eigen/Sparse; do
  refuses kernels/constraints/distance.h "#include <$header>"
done
refuses host/mesh/mesh.cpp '#include "tools/malha.cpp"'
refuses host/mesh/mesh.cpp '#include "tests/mesh_test.cpp"'
refuses host/mesh/mesh.cpp '#include "mesh.h"'
refuses host/mesh/mesh.cpp '#include "host/missing.h"'
refuses host/mesh/topology.h '#include "host/solver/solver.h"'
refuses host/malha/mesh.h '#include <Eigen/Core>'
refuses host/malha/scene.h '#include "kernels/simd/vec.h"'
refuses host/malha/simulation.h '#include <nlohmann/json.hpp>'
refuses tools/malha.cpp '#include "tests/mesh_test.cpp"'
refuses tests/mesh_test.cpp '#include "../host/mesh.h"'
refuses host/malha/scene.h 'std::map<int, int> numbers;'
refuses tools/page.h 'inline std::string name;  // std::vector'
printf '%d breaches refused\n' "$cases"
