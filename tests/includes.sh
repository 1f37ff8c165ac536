#!/usr/bin/env bash
# usage: includes.sh ROOT
# Refuses includes against the one direction (tools, tests -> host -> kernels), what a kernel cannot take to a GPU,
# and, in the installed headers, what would tie a caller to our flags.
set -euo pipefail
cd "${1:?usage: includes.sh ROOT}"

# Lines "FILE:LINE:INCLUDED", with its quotes or angle brackets, for the sources below the given folders.
includes_of() {
  find "$@" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.cu' \) -exec grep -HnE '^[[:space:]]*#[[:space:]]*include' {} + |
    sed -E 's/^([^:]+:[0-9]+:)[^<"]*([<"][^>"]*[>"]).*/\1\2/' | sort
}

breaches=0
# must FOLDERS ALLOWED WHY: every include below FOLDERS matches the pattern ALLOWED.
must() {
  local found
  # shellcheck disable=SC2086  # a list of folders
  found=$(includes_of $1 | grep -vE ":($2)\$" || true)
  if [[ -n "$found" ]]; then
    printf '%s\n' "$found" | sed "s|\$|  refused: $3|"
    breaches=$((breaches + $(wc -l <<<"$found")))
  fi
}

must kernels '"kernels/.*"|<(math|stddef|stdint|float|omp|sched)\.h>|<(type_traits|limits)>' \
  'a kernel includes kernels/, <math.h> and its like: nothing that allocates, throws, or is unknown to a GPU'
must host '"(kernels|host)/.*"|<.*>' 'host/ includes kernels/ and host/ by their path from the root, and no tools/ or tests/'
rooms=''
for room in base mesh scene model collision filter solver looks picture report output run; do
  rooms+="${rooms:+|}$room"
  if [[ -d host/$room ]]; then
    must "host/$room" "\"kernels/.*\"|\"host/($rooms)/.*\"|\"host/[a-z_]+\.h\"|<.*>" \
      "a room of host/ includes itself and the rooms before it: ${rooms//|/, }"
  fi
done
must tools '"(kernels|host|tools)/.*"|<.*>' 'tools/ includes kernels/, host/ and tools/ by their path from the root, and no tests/'
must tests '"(kernels|host|tools|tests)/.*"|<.*>' 'tests/ includes by the path from the root'

# What a caller includes, and all that these include, is installed.
public=(host/scene.h host/simulation.h)
for ((i = 0; i < ${#public[@]}; ++i)); do
  while IFS= read -r path; do
    if [[ -f "$path" && " ${public[*]} " != *" $path "* ]]; then public+=("$path"); fi
  done < <(includes_of "${public[i]}" | sed -nE 's/.*"(.*)"$/\1/p')
done
must "${public[*]}" '"host/.*"|<[a-z_]+>' \
  'an installed header includes host/ and the standard library only'

while IFS=: read -r file line included; do
  path=${included//\"/}
  if [[ "$included" == \"* && ! -f "$path" ]]; then
    printf '%s:%s:%s  refused: there is no such file\n' "$file" "$line" "$included"
    breaches=$((breaches + 1))
  fi
done < <(includes_of kernels host tools tests)

# One file knows a backend.
while read -r line; do
  printf '%s  refused: OpenMP is known to kernels/compute.h alone\n' "$line"
  breaches=$((breaches + 1))
done < <(grep -rnE '^[[:space:]]*#[[:space:]]*(pragma omp|include <omp\.h>)|omp_[a-z_]+\(' kernels host tools |
  grep -v '^kernels/compute\.h:' || true)

printf '%d forbidden includes\n' "$breaches"
((breaches == 0))
