#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: layout.sh ROOT
# The root has the known folders and nothing else, and no file has conflict markers of a merge. Files that git does not
# track are the user's own: a note, a log, a scene. Without git it is not known what is tracked, so that nothing is
# checked.
set -euo pipefail
cd "${1:?usage: layout.sh ROOT}"
faults=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

names=0
if [[ -e .git ]] && listed=$(git ls-files 2>/dev/null); then
  allowed=' CMakeLists.txt CMakePresets.json pyproject.toml LICENSE CONTRIBUTING.md CHANGELOG.md README.md CITATION.cff kernels host scenes tests tools .ci .clang-format .gitignore '
  while IFS= read -r name; do
    names=$((names + 1))
    [[ "$allowed" == *" $name "* ]] || fault "$name: found at the root; allowed:$allowed"
  done < <(cut --delimiter / --fields 1 <<<"$listed" | sort -u)
  while IFS= read -r line; do fault "${line:0:80}: found a conflict of a merge"; done \
    < <(git grep -I --line-number --extended-regexp '^(<<<<<<<|>>>>>>>) ' || true)
else
  printf 'no list of tracked files: what lies at the root is not looked at\n'
fi

printf '%d names at the root, %d faults\n' "$names" "$faults"
((faults == 0))
