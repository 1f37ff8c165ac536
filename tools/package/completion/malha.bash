# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Completes command lines of malha in bash. The program itself says what may follow.
_malha() {
  local line word
  COMPREPLY=()
  while IFS= read -r line; do
    word=${line%%$'\t'*}
    [[ $word == */ ]] && compopt -o nospace 2>/dev/null
    COMPREPLY+=("${word%/}")
  done < <("${COMP_WORDS[0]}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -o filenames -F _malha malha
