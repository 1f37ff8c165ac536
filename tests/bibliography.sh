#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: bibliography.sh ROOT
# host/bibliography.md has a row for every kind of constraint of the registry and of the schema, with a formula, a
# publication and the file that has the kind; the DOI of a link is that of its text, and CITATION.cff cites no other.
set -euo pipefail
cd "${1:?usage: bibliography.sh ROOT}"
page=host/bibliography.md registry=kernels/constraints/constraint_registry.h
faults=0 kinds=0 dois=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# check_kind NAME FILE: FILE may be empty, where the kind is not of the registry.
# shellcheck disable=SC2016  # backticks, as they stand in the page
check_kind() {
  local row cells
  kinds=$((kinds + 1))
  row=$(grep --fixed-strings "| \`$1\` |" "$page") || { fault "$page: found no row of the kind $1"; return; }
  IFS='|' read -ra cells <<<"${row//'\|'/}"
  [[ ${cells[2]} =~ [=] ]] || fault "$page: $1: found no formula"
  [[ ${cells[3]} =~ (19|20)[0-9]{2}|"no paper" ]] || fault "$page: $1: found no publication with its year"
  [[ -z $2 || ${cells[5]} == *"\`$2\`"* ]] || fault "$page: $1: found ${cells[5]}; allowed: $2, which has the kind"
}

types=$(sed -n '/^using ConstraintKinds/,/;/p' "$registry" | tr -d '\n' | sed 's/.*<\(.*\)>.*/\1/' | tr ',' '\n' | tr -d ' ')
for type in $types; do
  file=$(grep --files-with-matches --extended-regexp "^struct $type\b" kernels/constraints/*.h) || file=
  name=$(sed -n "/^struct $type\b/,/^};/s/.* name = \"\([a-z_]*\)\".*/\1/p" "${file:-/dev/null}" | head -n 1)
  if [[ -z $name ]]; then fault "$registry: found no name of $type"; else check_kind "$name" "$file"; fi
done
while IFS= read -r name; do check_kind "$name" ''; done < <(
  grep --only-matching '"type": {"const": "[a-z_]*"' scenes/schema.json | sed 's/.*"\([a-z_]*\)"$/\1/' |
    grep --invert-match --line-regexp --extended-regexp 'pbd|desbrun' | sort -u)  # solvers have types as well

while IFS=' ' read -r text link; do
  dois=$((dois + 1))
  link=${link//%28/(} link=${link//%29/)}
  [[ $text =~ ^10\.[0-9]{4,}/ && $link == "https://doi.org/$text" ]] || fault "$page: found the DOI $text with a link to $link"
done < <(grep --only-matching '\[10\.[^]]*\]([^ |]*' "$page" | sed 's/^\[\([^]]*\)\](/\1 /; s/[;,)]*$//')
while IFS= read -r doi; do
  grep --quiet --fixed-strings "[$doi]" "$page" || fault "CITATION.cff: found the DOI $doi, which $page lacks"
done < <(sed -n 's/^ *doi: *"\?\([^"]*\)"\?$/\1/p' CITATION.cff)

((kinds > 0 && dois > 0)) || fault "found $kinds kinds and $dois DOIs; allowed: some"
printf '%d kinds, %d DOIs, %d faults\n' "$kinds" "$dois" "$faults"
((faults == 0))
