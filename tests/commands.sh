#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: commands.sh ROOT MALHA
# Every command in the code of a page (in backticks, in a fence, or after build/release/) is there and answers --help,
# which names every option that the page gives it. So are the studies, benchmarks and scenes that commands name, and the
# tests that a --gtest_filter selects. What is not built beside MALHA is not asked.
set -euo pipefail
cd "${1:?usage: commands.sh ROOT MALHA}"
malha=${2:?usage: commands.sh ROOT MALHA}
beside=$(dirname "$malha")
faults=0 commands=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# commands_of PAGE: one a line, without comments; a line of a fence that goes on is one.
commands_of() {
  awk '
    function spans(  plain) {
      for (; match(text, /`[^`]+`/); text = substr(text, RSTART + RLENGTH)) {
        plain = plain substr(text, 1, RSTART - 1)
        print substr(text, RSTART + 1, RLENGTH - 2)
      }
      for (plain = plain text; match(plain, /build\/release\/malha [a-z]+/); plain = substr(plain, RSTART + RLENGTH))
        print substr(plain, RSTART, RLENGTH)
      text = ""
    }
    /^ *```/ { spans(); fenced = !fenced; next }
    fenced { sub(/ #.*/, ""); more = sub(/\\$/, ""); printf "%s%s", $0, more ? "" : "\n"; next }
    /^ *$/ { spans(); next }
    { text = text " " $0 }
    END { spans() }' "$1" | sed 's/&&/\n/g; s/[;|&<>]/\n/g' |
    grep --only-matching --extended-regexp \
      '(^ *|build/release/)(malha|malha_tests|tools/(package/)?[a-z]+|\.ci/run)( .*)?$' |
    sed 's/^ *//; s|^build/release/||' || true
}

# listed TITLE: the names that a help on standard input lists below it.
listed() { sed -n "/^$1:/,/^\$/s/^  \([a-z]*\) .*/\1/p"; }
# one_of WORD WHAT NAMES: WORD is a placeholder of the page, or among NAMES.
one_of() {
  [[ "$1" =~ ^[A-Z]+$ ]] || grep --quiet --line-regexp --fixed-strings -e "$1" <<<"$3" ||
    fault "$page: found $2 $1, which the help does not list"
}

known=$("$malha" --help | listed Commands)
studies='' benchmarks=''
if [[ -x "$beside/malha_measures" ]]; then
  studies=$(printf 'all\n' && "$malha" study --help | listed Studies)
  benchmarks=$("$malha" bench --help | listed Benchmarks)
fi
declare -A help
while IFS= read -r page; do
  while IFS= read -r command; do
    read -r -a words <<<"${command//[\'\"]/}"
    commands=$((commands + 1))
    for word in "${words[@]}"; do
      case "$word" in
        scenes/*.json) compgen -G "$word" >/dev/null || fault "$page: $command: found no scene $word" ;;
        --gtest_filter=*)
          [[ -x "$beside/malha_tests" ]] || continue
          IFS=: read -r -a patterns <<<"${word#*=}"
          for pattern in "${patterns[@]}"; do
            "$beside/malha_tests" --gtest_list_tests --gtest_filter="$pattern" | grep --quiet '^  ' ||
              fault "$page: $command: found no test $pattern"
          done
          ;;
      esac
    done
    program=("$malha")
    case "${words[0]}" in
      malha_tests) continue ;;
      malha)
        name=${words[1]-} measure=${words[2]-}
        if [[ "$name" =~ ^[^-] ]]; then
          one_of "$name" command "$known"
          grep --quiet --line-regexp --fixed-strings -e "$name" <<<"$known" || continue
          program+=("$name")
        fi
        case "$name" in
          view) [[ -x "${malha}_view" ]] || continue ;;
          tune | bench | study) [[ -n "$studies" ]] || continue ;;
        esac
        if [[ "$measure" =~ ^[^-] ]]; then
          case "$name" in
            study) one_of "$measure" study "$studies" ;;
            bench)
              one_of "$measure" benchmark "$benchmarks"
              if grep --quiet --line-regexp -e "$measure" <<<"$benchmarks"; then program+=("$measure"); fi
              ;;
          esac
        fi
        ;;
      *)
        [[ -e "${words[0]}" ]] || fault "$page: found no ${words[0]}"
        [[ -f "${words[0]}" ]] || continue  # a folder
        program=("${words[0]}")
        ;;
    esac
    key="${program[*]}"
    if [[ -z "${help[$key]-}" ]]; then
      help[$key]=$("${program[@]}" --help 2>&1 </dev/null) || fault "$page: $key --help ends with status $?"
    fi
    for word in "${words[@]}"; do
      option=${word%%=*}
      [[ "$option" =~ ^--[a-z-]+$ && "$option" != --help ]] || continue
      [[ "${words[0]}" == tools/test && "$option" == --output-on-failure ]] && continue  # ctest's
      grep --quiet --word-regexp -e "$option" <<<"${help[$key]}" ||
        fault "$page: $key: found $option, which its help does not name"
    done
  done < <(commands_of "$page")
done < <(find ./*.md kernels host scenes tests tools -name '*.md')

printf '%d commands, %d faults\n' "$commands" "$faults"
((commands > 50 && faults == 0))
