#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: includes.sh ROOT
# Refuses includes against the one direction (tools, tests -> host -> kernels), what a kernel cannot include on a GPU,
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

# in_order TOP FOLDERS ALSO: a folder of TOP includes itself, the folders before it in FOLDERS, and what matches ALSO.
in_order() {
  local folder earlier='' known=" $2 "
  for folder in $2; do
    earlier+="${earlier:+|}$folder"
    if [[ -d $1/$folder ]]; then
      must "$1/$folder" "\"$1/($earlier)/.*\"|$3" \
        "a folder of $1/ includes itself and the folders before it: ${earlier//|/, }"
    fi
  done
  for folder in "$1"/*/; do
    folder=$(basename "$folder")
    if [[ "$known" != *" $folder "* ]]; then
      printf '%s/%s: found no place for it in the order of includes\n' "$1" "$folder"
      breaches=$((breaches + 1))
    fi
  done
}

must kernels '"kernels/.*"|<(math|stddef|stdint|float|omp|sched)\.h>|<(type_traits|limits|utility)>' \
  'a kernel includes kernels/, <math.h> and its like: nothing that allocates, throws, or is unknown to a GPU'
in_order kernels 'parallel simd geometry measure projection constraints attachments forces filter multilevel self_collision environment patch' '<.*>'
must host '"(kernels|host|malha)/.*"|<.*>' \
  'host/ includes kernels/ and host/ by their path from the root, malha/, and no tools/ or tests/'
in_order host 'malha base mesh scene animation model measure filter projection attachments patch multilevel forces environment self_collision solver fields render report output run' \
  '"kernels/.*"|"malha/.*"|<.*>'
must tools '"(kernels|host|malha|tools)/.*"|<.*>' \
  'tools/ includes kernels/, host/ and tools/ by their path from the root, malha/, and no tests/'
must tests '"(kernels|host|malha|tools|tests)/.*"|<.*>' 'tests/ includes by the path from the root, or malha/'

# Headers that callers include, which are installed.
must host/malha '"malha/.*"|<[a-z_]+>' 'a public header includes malha/ and the standard library only'

while IFS=: read -r file line included; do
  path=${included//\"/}
  if [[ "$path" == malha/* ]]; then path=host/$path; fi
  if [[ "$included" == \"* && ! -f "$path" ]]; then
    printf '%s:%s:%s  refused: there is no such file\n' "$file" "$line" "$included"
    breaches=$((breaches + 1))
  fi
done < <(includes_of kernels host tools tests)

# Only one file may include a backend.
while read -r line; do
  printf '%s  refused: OpenMP is known to kernels/parallel/compute.h alone\n' "$line"
  breaches=$((breaches + 1))
done < <(grep -rnE '^[[:space:]]*#[[:space:]]*(pragma omp|include <omp\.h>)|omp_[a-z_]+\(' kernels host tools |
  grep -v '^kernels/parallel/compute\.h:' || true)

# Each header includes what it takes from the standard library, or a header of ours that does. Those of kernels/ and
# host/ are also compiled alone (tests/CMakeLists.txt).
names='
  algorithm:sort,stable_sort,clamp,max_element,min_element,any_of,all_of,none_of,find_if,fill,lower_bound array:array
  atomic:atomic bit:bit_cast chrono:chrono condition_variable:condition_variable deque:deque exception:exception_ptr
  filesystem:filesystem fstream:ifstream,ofstream functional:function limits:numeric_limits map:map,multimap
  memory:unique_ptr,shared_ptr,make_unique,make_shared mutex:mutex,lock_guard,unique_lock optional:optional,nullopt
  random:mt19937 set:set span:span sstream:ostringstream,istringstream,stringstream
  stdexcept:runtime_error,logic_error,invalid_argument,out_of_range string:string,to_string string_view:string_view
  thread:thread tuple:tuple unordered_map:unordered_map variant:variant vector:vector'
while read -r line; do
  printf '%s\n' "$line"
  breaches=$((breaches + 1))
done < <(find kernels host tools -name '*.h' -exec awk -v names="$names" '
  BEGIN {
    for (i = split(names, entries, " "); i > 0; --i) {
      split(entries[i], entry, ":")
      for (j = split(entry[2], words, ","); j > 0; --j) home[words[j]] = entry[1]
    }
  }
  /^#include "/ { split($0, part, "\""); sub("^malha/", "host/malha/", part[2]); ours[FILENAME] = ours[FILENAME] " " part[2] }
  /^#include </ { split($0, part, "[<>]"); has[FILENAME, part[2]] = 1 }
  { sub("//.*", "") }
  /std::/ {
    for (rest = $0; match(rest, /std::[a-z_0-9]+/); rest = substr(rest, RSTART + RLENGTH)) {
      word = substr(rest, RSTART + 5, RLENGTH - 5)
      if (word in home && !((FILENAME, word) in place)) place[FILENAME, word] = FNR
    }
  }
  function provides(file, header, i, n, all) {
    if ((file, header) in has) return 1
    if (seen[file]++) return 0
    for (i = n = split(ours[file], all, " "); i > 0; --i) if (provides(all[i], header)) return 1
    return 0
  }
  END {
    for (key in place) {
      split(key, part, SUBSEP)
      split("", seen)
      if (!provides(part[1], home[part[2]]))
        print part[1] ":" place[key] ":<" home[part[2]] ">  refused: it has std::" part[2] ", and nothing includes that"
    }
  }' {} + | sort)

printf '%d forbidden includes\n' "$breaches"
((breaches == 0))
