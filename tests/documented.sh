#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: documented.sh ROOT
# scenes/README.md names every key and every word that scenes/schema.json allows: in backticks, or quoted in a JSON
# example.
set -euo pipefail
cd "${1:?usage: documented.sh ROOT}"
page=scenes/README.md schema=scenes/schema.json
faults=0 names=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# schema_names FILE: the keys of every "properties", the strings of every "enum" and "const".
schema_names() {
  awk '
    {
      line = $0
      while (match(line, /"([^"\\]|\\.)*"|[][{}:,]/)) {
        token = substr(line, RSTART, RLENGTH)
        line = substr(line, RSTART + RLENGTH)
        if (token == "{" || token == "[") {
          within[++depth] = after
          after = ""
        } else if (token == "}" || token == "]") {
          --depth
          after = ""
        } else if (token == ",") {
          after = ""
        } else if (token == ":") {
          after = text
          if (within[depth] == "properties") print text
        } else {
          text = substr(token, 2, length(token) - 2)
          if (after == "const" || within[depth] == "enum") print text
        }
      }
    }' "$1" | sort -u
}

# said FILE: what stands in backticks, and what is quoted there or in a JSON example.
said() {
  awk '
    function quoted(code) {
      while (match(code, /"[^"]*"/)) {
        print substr(code, RSTART + 1, RLENGTH - 2)
        code = substr(code, RSTART + RLENGTH)
      }
    }
    function spans(text,  code) {
      while (match(text, /`[^`]+`/)) {
        code = substr(text, RSTART + 1, RLENGTH - 2)
        text = substr(text, RSTART + RLENGTH)
        print code
        quoted(code)
      }
    }
    /^ *```/ { fenced = !fenced; json = fenced && /```json/; spans(text); text = ""; next }
    fenced { if (json) quoted($0); next }
    /^ *$/ { spans(text); text = ""; next }
    { text = text " " $0 }
    END { spans(text) }' "$1" | sort -u
}

on_page=$(said "$page")
while IFS= read -r name; do
  names=$((names + 1))
  grep --quiet --line-regexp --fixed-strings -- "$name" <<<"$on_page" ||
    fault "$page: found nothing on \"$name\" of $schema; allowed: every key and word in backticks or in a JSON example"
done < <(schema_names "$schema")

((names > 0)) || fault "found no name in $schema; allowed: some"
printf '%d keys and words, %d faults\n' "$names" "$faults"
((faults == 0))
