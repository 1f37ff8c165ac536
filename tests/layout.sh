#!/usr/bin/env bash
# usage: layout.sh ROOT
# The root holds the rooms of the house and nothing else; no file that people read is longer than 500 lines. What git
# does not track is the user's own: a note, a log, a scene. Without git nobody knows what is tracked: then only the
# rooms are looked through.
set -euo pipefail
cd "${1:?usage: layout.sh ROOT}"
faults=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

files=()
if [[ -e .git ]] && listed=$(git ls-files 2>/dev/null); then
  rooms=' CMakeLists.txt CMakePresets.json LICENSE README.md kernels host scenes tests tools .ci .clang-format .gitignore '
  while IFS= read -r name; do
    [[ "$rooms" == *" $name "* ]] || fault "$name: found at the root; allowed:$rooms"
  done < <(cut --delimiter / --fields 1 <<<"$listed" | sort -u)
  while IFS= read -r -d '' file; do files+=("$file"); done < <(git ls-files -z)
else
  printf 'no list of tracked files: what lies at the root is not looked at\n'
  while IFS= read -r -d '' file; do files+=("$file"); done < <(find kernels host scenes tests tools -type f -print0)
fi

read_by_people=()
for file in "${files[@]}"; do
  case "$file" in scenes/meshes/* | tools/study/charts/* | *.png) continue ;; esac
  if [[ -f "$file" ]]; then read_by_people+=("$file"); fi  # else removed, but not yet from the list
done
while read -r lines file; do
  [[ "$file" == total ]] || ((lines <= 500)) || fault "$file: found $lines lines; allowed: 500"
done < <(printf '%s\0' "${read_by_people[@]}" | wc -l --files0-from=-)

printf '%d files, %d faults\n' "${#files[@]}" "$faults"
((faults == 0))
