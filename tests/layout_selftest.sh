#!/usr/bin/env bash
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
touch README.md kernels/one.h
yes | head -501 >kernels/long.h || true
expect 1 "kernels/long.h: found 501 lines; allowed: 500" "a long file, without git"
rm kernels/long.h
touch notes.txt
expect 0 " 0 faults" "the user's own note, without git"

command -v git >/dev/null || exit 0
git init --quiet .
git add README.md kernels
expect 0 " 0 faults" "the user's own note, which is not tracked"
yes | head -501 >my_log.txt || true
cp my_log.txt kernels/my_log.txt
expect 0 " 0 faults" "the user's own long files"
git add notes.txt
expect 1 "notes.txt: found at the root; allowed:" "a note that is tracked"
git reset --quiet notes.txt 2>/dev/null || git rm --quiet --cached notes.txt
git add kernels/my_log.txt
expect 1 "kernels/my_log.txt: found 501 lines; allowed: 500" "a long file that is tracked"
rm kernels/my_log.txt
expect 0 " 0 faults" "a file that is tracked, and gone"
((faults == 0))
