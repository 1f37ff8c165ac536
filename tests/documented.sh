#!/usr/bin/env bash
# usage: documented.sh ROOT
# scenes/README.md names every key and every word that scenes/schema.json allows: in backticks, or quoted in a JSON
# example. No sentence of a page (README.md and what lies beside one) has more than 25 words, and no cell of a table
# more between two semicolons. Code and headings are not sentences; what stands in backticks counts as one word.
set -euo pipefail
cd "${1:?usage: documented.sh ROOT}"
most=25 page=scenes/README.md schema=scenes/schema.json
faults=0 names=0 sentences=0 pages=0
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

# sentences FILE: for each its line (that of its paragraph or row), its number of words, and itself.
sentences() {
  awk '
    function flush(  rest, end, sentence, part, parts, words, i) {
      gsub(/!?\[/, "", text)  # of a link or picture stays what it says
      gsub(/\]\([^)]*\)/, "", text)
      rest = text " "
      sub(/^ +/, "", rest)
      while (rest != "") {
        sentence = ""
        while (rest != "") {
          end = match(rest, /[.!?]["\047)*_]* +/) ? RSTART + RLENGTH - 1 : length(rest)
          sentence = sentence substr(rest, 1, end)
          rest = substr(rest, end + 1)
          if (sentence !~ /(^|[ (])(al|e\.g|i\.e|vs|cf|Fig|Eq)\. +$/) break
        }
        words = 0
        parts = split(sentence, part, /[ \t]+/)
        for (i = 1; i <= parts; ++i) words += part[i] ~ /[A-Za-z0-9\200-\377]/
        if (words > 0) print start, words, sentence
      }
      text = ""
    }
    # Code in backticks becomes one word: a command is read as one thing. It may go on in the next line.
    function add(line) {
      if (text == "") start = FNR
      text = text " " line
      while (match(text, /`[^`]+`/)) text = substr(text, 1, RSTART - 1) "CODE" substr(text, RSTART + RLENGTH)
    }
    /^ *```/ { flush(); fenced = !fenced; next }
    fenced { next }
    /^ *$/ || /^#/ { flush(); next }
    /^ *\|/ {
      flush()
      add($0)
      gsub(/\\\|/, "", text)  # a sign, not the end of a cell
      cells = split(text, cell, /[|;]/)
      for (i = 1; i <= cells; ++i) {
        text = cell[i]
        flush()
      }
      next
    }
    /^ *([-*+]|[0-9]+\.) / { flush(); sub(/^ *([-*+]|[0-9]+\.) +/, "") }
    { sub(/^ +/, ""); add($0) }
    END { flush() }' "$1"
}

on_page=$(said "$page")
while IFS= read -r name; do
  names=$((names + 1))
  grep --quiet --line-regexp --fixed-strings -- "$name" <<<"$on_page" ||
    fault "$page: found nothing on \"$name\" of $schema; allowed: every key and word in backticks or in a JSON example"
done < <(schema_names "$schema")

while IFS= read -r file; do
  pages=$((pages + 1))
  while read -r line words sentence; do
    sentences=$((sentences + 1))
    ((words <= most)) || fault "$file:$line: found a sentence of $words words; allowed: $most; it reads: $sentence"
  done < <(sentences "$file")
done < <(find README.md kernels host scenes tests tools -name '*.md')

((names > 0 && sentences > 0)) || fault "found $names names in $schema and $sentences sentences; allowed: some"
printf '%d keys and words, %d sentences of %d pages, %d faults\n' "$names" "$sentences" "$pages" "$faults"
((faults == 0))
