#!/usr/bin/env bash
# usage: commands.sh ROOT MALHA
# Every command that a page names answers --help, and its help names every option that the page gives it.
set -euo pipefail
cd "${1:?usage: commands.sh ROOT MALHA}"
malha=${2:?usage: commands.sh ROOT MALHA}
faults=0 commands=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# commands_of PAGE: from code blocks and from what stands in backticks, without comments; a line that goes on is one.
# shellcheck disable=SC2016  # backticks, as they stand in the page
commands_of() {
  sed 's/ #.*//' "$1" | sed ':more; /\\$/{N; s/\\\n//; b more}' | tr '`' '\n' |
    grep --only-matching --extended-regexp '^ *(build/release/)?(malha [a-z]+|tools/(package/)?[a-z]+ |tools/(package/)?[a-z]+$|\.ci/run)[^;|&<>]*' | sed 's/^ *//' || true
}

known=$("$malha" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
declare -A help
while IFS= read -r page; do
  while IFS= read -r command; do
    read -r -a words <<<"${command#build/release/}"
    program=("$malha")
    case "${words[0]}" in
      malha)
        grep --quiet --line-regexp -e "${words[1]}" <<<"$known" || continue  # malha in a sentence
        [[ "${words[1]}" == view && ! -x "${malha}_view" ]] && continue
        program+=("${words[1]}")
        if [[ "${words[1]}" == bench && "${words[2]-}" =~ ^[a-z]+$ ]]; then program+=("${words[2]}"); fi
        ;;
      *)
        [[ -f "${words[0]}" ]] || continue  # a folder
        program=("${words[0]}")
        ;;
    esac
    commands=$((commands + 1))
    key="${program[*]}"
    if [[ -z "${help[$key]-}" ]]; then
      help[$key]=$("${program[@]}" --help 2>&1 </dev/null) || fault "$page: $key --help ends with status $?"
    fi
    for word in "${words[@]}"; do
      option=${word%%=*}
      [[ "$option" =~ ^--[a-z-]+$ && "$option" != --help ]] || continue
      [[ "${words[0]}" == tools/test && "$option" == --output-on-failure ]] && continue  # ctest's
      grep --quiet --word-regexp -e "$option" <<<"${help[$key]}" || fault "$page: $key: found $option, which its help does not name"
    done
  done < <(commands_of "$page")
done < <(find README.md kernels host scenes tests tools -name '*.md')

printf '%d commands, %d faults\n' "$commands" "$faults"
((commands > 50 && faults == 0))
