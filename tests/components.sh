#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: components.sh ROOT BUILD COMPILER
# The library alone needs Eigen and Embree and nothing else that a part needs. It is installed and serves a program
# (tests/components), and is a part of another project, which is only configured. Parts that need each other are refused.
# It is built beside BUILD with the options of BUILD, so that ccache has most of it. Without ccache this would take
# minutes, and is skipped.
set -euo pipefail
root=${1:?} build=${2:?} compiler=${3:?}
alone=$build-alone
command -v ccache >/dev/null || { echo "skipped: without ccache the library would be compiled again"; exit 77; }
command -v ninja >/dev/null || { echo "skipped: ninja lists the headers that are read"; exit 77; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
faults=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}
option() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
configure() { # FOLDER SOURCES OPTIONS...
  cmake -S "$2" -B "$1" -G Ninja -D CMAKE_CXX_COMPILER="$compiler" -D CMAKE_BUILD_TYPE="$(option CMAKE_BUILD_TYPE)" \
    -D MALHA_NATIVE="$(option MALHA_NATIVE)" -D MALHA_WERROR="$(option MALHA_WERROR)" "${@:3}"
}
refuses() { # WORDS OPTIONS...
  local words=$1
  shift
  rm -rf "$scratch/refused"
  if configure "$scratch/refused" "$root" "$@" >"$scratch/said" 2>&1; then
    fault "$*: was not refused"
  elif ! tr --squeeze-repeats ' \n' ' ' <"$scratch/said" | grep --quiet --fixed-strings -- "$words"; then
    fault "$*: found $(tail -n 8 "$scratch/said")"
  fi
}

# Every part of the list at the head of CMakeLists.txt, so that a new one is left out here as well.
parts=$(sed -n 's/^malha_component(\([A-Z]*\) .*/\1/p' "$root/CMakeLists.txt")
off=()
for part in $parts; do off+=(-D "MALHA_$part=OFF"); done
refuses 'MALHA_PAGES: found ON with MALHA_JSON=OFF; allowed: OFF, or MALHA_JSON=ON' -D MALHA_JSON=OFF
refuses 'MALHA_METIS: found "perhaps"; allowed: ON, OFF' -D MALHA_METIS=perhaps
refuses 'MALHA_TESTS: found ON with MALHA_METIS=OFF; allowed: OFF, or MALHA_METIS=ON' -D MALHA_METIS=OFF

configure "$alone" "$root" "${off[@]}" >"$scratch/said" || { cat "$scratch/said"; exit 1; }
cmake --build "$alone" >"$scratch/said" || { tail -n 40 "$scratch/said"; exit 1; }

# What was searched for and what was read.
while IFS= read -r name; do fault "CMakeCache.txt: found $name, which the library alone does not need"; done < <(
  grep --only-matching --extended-regexp '^(METIS|ZLIB|STB|THREE|TINYGLTF|IMGUI|EPOXY|PYBIND11|OPENBLAS|CLI11|nlohmann_json|glfw3|Bullet|GTest|Python3)[A-Za-z0-9_]*' \
    "$alone/CMakeCache.txt" || true)
headers=$(ninja -C "$alone" -t deps | grep --only-matching --extended-regexp '/(eigen3|embree[0-9]|nlohmann|metis\.h|zlib\.h|stb|tiny_gltf\.h|CLI|GLFW|epoxy|imgui|pybind11|gtest)\b' | sort -u | paste --serial --delimiters ' ')
[[ $headers =~ ^/eigen3\ /embree[34]$ ]] || fault "headers: found $headers; allowed: /eigen3 /embree3 or 4"

# Installed, it is found without the other libraries as well, and says what it lacks.
cmake --install "$alone" --prefix "$scratch/prefix" >/dev/null
consumer=$root/tests/components
configure "$scratch/consumer" "$consumer" -D CMAKE_PREFIX_PATH="$scratch/prefix" >"$scratch/said" 2>&1 ||
  { cat "$scratch/said"; exit 1; }
cmake --build "$scratch/consumer" >"$scratch/said" || { tail -n 40 "$scratch/said"; exit 1; }
"$scratch/consumer/alone" "$scratch/checkpoint"
if configure "$scratch/other" "$consumer" -D CMAKE_PREFIX_PATH="$scratch/prefix" -D PARTS=JSON >"$scratch/said" 2>&1; then
  fault "find_package(malha COMPONENTS JSON): was not refused"
fi
third_party=$scratch/prefix/share/doc/malha/THIRD_PARTY
[[ -s $scratch/prefix/share/doc/malha/LICENSE ]] || fault "LICENSE: found none that is installed"
names=$(sed -n '/^====/q; s/^  \(.*\) (.*)$/\1/p' "$third_party" | paste --serial --delimiters ' ')
[[ $names == Eigen ]] || fault "THIRD_PARTY: found $names; allowed: Eigen"
grep --quiet 'Mozilla Public License' "$third_party" || fault "THIRD_PARTY: found no text of Eigen's licence"

# As a part of another project it builds the library and nothing else, and that project links its target.
configure "$scratch/part" "$consumer" -D MALHA_SOURCES="$root" >"$scratch/said" 2>&1 || { cat "$scratch/said"; exit 1; }
targets=$(ninja -C "$scratch/part" -t targets all | sed -n 's/^\([^ :]*\): CXX_\(STATIC_LIBRARY\|EXECUTABLE\|MODULE_LIBRARY\)_LINKER.*/\1/p' |
  xargs -n 1 basename | sort | paste --serial --delimiters ' ')
[[ $targets == 'alone libmalha.a' ]] || fault "FetchContent: found the targets $targets; allowed: alone libmalha.a"

printf '%d faults\n' "$faults"
((faults == 0))
