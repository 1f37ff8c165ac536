#!/usr/bin/env bash
# usage: layout.sh ROOT
# The root holds the rooms of the house and nothing else; no file that people read is longer than 500 lines.
set -euo pipefail
cd "${1:?usage: layout.sh ROOT}"
faults=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# build/ and out/ are not part of the repository.
rooms=' CMakeLists.txt CMakePresets.json LICENSE README.md kernels host scenes tests tools build out '
for name in *; do
  [[ "$rooms" == *" $name "* ]] || fault "$name: found at the root; allowed:$rooms"
done

while IFS= read -r -d '' file; do
  lines=$(wc -l <"$file")
  ((lines <= 500)) || fault "$file: found $lines lines; allowed: 500"
done < <(find ./*.* LICENSE .ci .clang-* .gitignore kernels host scenes tests tools \( -path scenes/meshes -o -path tools/study/charts \) -prune -o -type f -print0)

printf '%d faults\n' "$faults"
((faults == 0))
