# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Completes malha's commands and options in bash. They are read from its help, so that they are never out of date.
_malha() {
  local now=${COMP_WORDS[COMP_CWORD]} first=$((COMP_CWORD < 2 ? 1 : 2)) help words
  if [[ ${COMP_WORDS[1]} == bench ]] && ((COMP_CWORD > 2)); then first=3; fi  # each benchmark has its own help
  help=$("${COMP_WORDS[@]:0:first}" --help 2>/dev/null)
  if [[ $now == -* ]]; then
    words=$(grep --only-matching -e '^  [^ ]*' <<<"$help" | tr ',' '\n' | grep --only-matching -e '--[a-z-]*')
  else
    words=$(sed -n '/^\(Commands\|Benchmarks\|Studies\):/,/^$/s/^  \([a-z][a-z]*\) .*/\1/p' <<<"$help")
    if [[ -z $words ]]; then
      mapfile -t COMPREPLY < <(compgen -f -X '!*.@(json|obj|ply|off|stl|node|ele|msh|mesh)' -- "$now"; compgen -d -- "$now")
      return
    fi
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$now")
}
shopt -s extglob
complete -o filenames -F _malha malha
