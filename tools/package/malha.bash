# Completes malha's commands and options in bash. Both are read from its help, so that they are never out of date.
_malha() {
  local now=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]} words
  if ((COMP_CWORD == 1)); then
    words=$("$program" --help 2>/dev/null | sed -n '/^Commands:/,/^$/s/^  \([a-z][a-z]*\) .*/\1/p')
  elif [[ $now == -* ]]; then
    words=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null | grep --only-matching -e '^  [^ ]*' | tr ',' '\n' | grep --only-matching -e '--[a-z-]*')
  else
    mapfile -t COMPREPLY < <(compgen -f -X '!*.@(json|obj|ply|off|stl|node|ele|msh|mesh)' -- "$now"; compgen -d -- "$now")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$now")
}
shopt -s extglob
complete -o filenames -F _malha malha
