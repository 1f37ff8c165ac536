#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: pages.sh ROOT [links]
# Every link and picture of the pages (README.md and those of the rooms) leads to a file, and to a heading where it
# names one. Source files that they name are there: from the root, or in the page's own folder or below. The first
# page begins with a picture that loads at once. With "links" only links are looked at: where
# pages are installed, sources are not.
set -euo pipefail
cd "${1:?usage: pages.sh ROOT [links]}"
only=${2-}
faults=0 links=0
files=$(find kernels host scenes tests tools -type f)
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}
# headings FILE: as links name them: small letters, hyphens for blanks, without other signs.
# shellcheck disable=SC2016  # backticks, as they stand in the page
headings() { sed -n '/^```/,/^```/d; s/^#\+ //p' "$1" | tr '[:upper:]' '[:lower:]' | sed "s/[^a-z0-9 _-]//g; s/ /-/g"; }
# shellcheck disable=SC2016
sources() { grep --only-matching '`[a-zA-Z0-9_/.-]*\.\(h\|cpp\|cu\|sh\|js\|py\)`' "$1"; }

while IFS= read -r page; do
  while IFS= read -r target; do
    links=$((links + 1))
    case "$target" in http://* | https://*) continue ;; esac
    file=${target%%#*}
    file=${file:+$(dirname "$page")/$file}
    file=${file:-$page}
    if [[ ! -e "$file" ]]; then
      fault "$page: found a link to $target, which is not there"
    elif [[ "$target" == *'#'* ]] && ! headings "$file" | grep --quiet --line-regexp --fixed-strings -- "${target#*#}"; then
      fault "$page: found a link to $target, a heading that is not there"
    fi
  done < <(grep --only-matching '](\([^)]*\))' "$page" | sed 's/^](//; s/)$//')
  [[ $only == links ]] && continue
  room=$(dirname "$page")
  while IFS= read -r name; do
    grep --quiet "^\($name\|${room#./}/\(.*/\)\?$name\)\$" <<<"$files" || fault "$page: found no file $name"
  done < <(sources "$page" | tr -d '`' | grep --invert-match NAME)
done < <(find ./*.md kernels host scenes tests tools -name '*.md')

picture=$(sed -n '2,5s/^!\[.*\](\(.*\))$/\1/p' README.md)
if [[ -z "$picture" ]]; then
  fault "README.md: found no picture below its title"
elif [[ -f "$picture" ]] && (($(wc -c <"$picture") >= 200000)); then
  fault "$picture: found $(wc -c <"$picture") bytes; allowed: less than 200000"
fi

printf '%d links, %d faults\n' "$links" "$faults"
((faults == 0))
