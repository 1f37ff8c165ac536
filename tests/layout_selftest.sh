#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: layout_selftest.sh
# What layout.sh lets through and what it refuses: in a repository, and in a folder without one.
set -euo pipefail
layout=$(dirname "$(realpath "${BASH_SOURCE[0]}")")/layout.sh
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
unset GIT_DIR GIT_INDEX_FILE GIT_WORK_TREE  # of a hook that runs the tests
faults=0
expect() {  # STATUS WORDS CASE
  local status=0
  "$layout" "$scratch" >said 2>&1 || status=$?
  if ((status != $1)) || ! grep --quiet --fixed-strings -- "$2" said; then
    printf '%s: found status %d and\n%s\n' "$3" "$status" "$(cat said)"
    faults=$((faults + 1))
  fi
}

mkdir kernels host scenes tests tools
touch README.md kernels/one.h notes.txt
expect 0 " 0 faults" "the user's own note, without git"

command -v git >/dev/null || exit 0
git init --quiet .
git add README.md kernels
expect 0 " 0 faults" "the user's own note, which is not tracked"
git add notes.txt
expect 1 "notes.txt: found at the root; allowed:" "a note that is tracked"
git rm --quiet --cached notes.txt
printf 'a page\n%s ours\n=======\n%s theirs\n' '<<<<<<<' '>>>>>>>' >README.md
expect 1 "README.md:2:<<<<<<< ours: found a conflict of a merge" "a conflict that was committed"
((faults == 0))
