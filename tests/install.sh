#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: install.sh ROOT BUILD GENERATOR COMPILER python=PYTHON folder=FOLDER
# Installs BUILD into a scratch prefix; configures, builds and runs tools/examples against it, with the compiler's
# default instruction set. The C++ of README.md is built so, too. PYTHON, if it is not empty, imports the module from
# FOLDER below the prefix. The links of the installed pages must lead to files; licences and completion are installed
# with them.
set -euo pipefail
root=${1:?} build=${2:?} generator=${3:?} compiler=${4:?} python=${5#python=} folder=${6#folder=}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
cmake -S "$root/tools/examples" -B "$scratch/build" -G "$generator" \
  -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release
cmake --build "$scratch/build"

# A scene with particles, constraints and a mesh to collide with, so that every dependency is called.
"$scratch/build/run" "$root/scenes/ramp.json"
for name in own_loop own_constraint several; do "$scratch/build/$name" "$root/scenes/sheet_shear.json"; done
# On threads of their own these compare their bits with OpenMP's, in a scene whose launches have several groups.
for name in own_threads game_loop tbb_arena; do
  if [[ $name != tbb_arena || -e "$scratch/build/$name" ]]; then "$scratch/build/$name" "$root/scenes/long_cloth.json"; fi
done
# The C++ of the first page runs unchanged, with the scene of that page.
mkdir "$scratch/page"
block() { sed -n "/^\`\`\`$1\$/,/^\`\`\`\$/p" "$root/README.md" | sed '/^```/d'; }
block cpp >"$scratch/page/page.cpp"
block json >"$scratch/page/sheet.json"
cat >"$scratch/page/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.21)
project(page LANGUAGES CXX)
find_package(malha CONFIG REQUIRED)
add_executable(page page.cpp)
target_link_libraries(page PRIVATE malha::malha)
CMAKE
cmake -S "$scratch/page" -B "$scratch/page/build" -G "$generator" \
  -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release
cmake --build "$scratch/page/build"
(cd "$scratch/page" && build/page >positions)
(($(wc -l <"$scratch/page/positions") == 17 * 17)) || {
  printf 'README.md: found %d particles; allowed: the 289 of its scene\n' "$(wc -l <"$scratch/page/positions")"
  exit 1
}
"$root/tests/pages.sh" "$scratch/prefix/share/doc/malha" links
"$scratch/prefix/bin/malha" --help >/dev/null
for name in Eigen nlohmann-json stb three.js CLI11; do  # which every build with tests has
  grep --quiet "^==== $name (" "$scratch/prefix/share/doc/malha/THIRD_PARTY" ||
    { echo "THIRD_PARTY: found no licence of $name"; exit 1; }
done
for file in doc/malha/LICENSE bash-completion/completions/malha zsh/site-functions/_malha \
  fish/vendor_completions.d/malha.fish; do
  [[ -s $scratch/prefix/share/$file ]] || { echo "share/$file: is not installed"; exit 1; }
done
if [[ -e "$build/malha_measures" ]]; then
  "$scratch/prefix/bin/malha" bench --help >/dev/null
  # The command hands the installed script of a study in Python to the Python that is named.
  said=$(MALHA_PYTHON=$(command -v echo) "$scratch/prefix/bin/malha" study validation --quick)
  [[ "$said" == "$scratch/prefix/share/malha/study/validation.py --quick" ]] ||
    { printf 'malha study validation: found "%s"; allowed: the installed script\n' "$said"; exit 1; }
fi
if [[ -n "$python" ]]; then
  PYTHONPATH=$scratch/prefix/$folder "$python" -c "
import malha
malha.Simulation('$root/scenes/ramp.json').step()
assert malha._command() == '$scratch/prefix/bin/malha', malha._command()"
  if [[ -e "$build/malha_measures" ]] && "$python" -c "import numpy, scipy, matplotlib" 2>/dev/null; then
    PYTHONPATH=$scratch/prefix/$folder "$python" "$scratch/prefix/share/malha/study/validation.py" --help >/dev/null
    PYTHONPATH=$scratch/prefix/$folder "$python" -c "import _malha_reference"
  fi
fi
