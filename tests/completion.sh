#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: completion.sh ROOT MALHA
# bash, zsh and fish complete commands, options, values and files from what the program says. A shell that is not
# installed is named and left out; without any but bash that is all.
set -euo pipefail
root=$(realpath "${1:?usage: completion.sh ROOT MALHA}") malha=$(realpath "${2:?usage: completion.sh ROOT MALHA}")
scripts=$root/tools/package/completion
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$scratch/bin" "$scratch/scenes/folder" "$scratch/home"
ln -s "$malha" "$scratch/bin/malha"
for program in malha_measures malha_view; do
  if [[ -x $(dirname "$malha")/$program ]]; then ln -s "$(dirname "$malha")/$program" "$scratch/bin/$program"; fi
done
touch "$scratch/scenes/"{ball,"a ball",flag}.json "$scratch/scenes/mesh.obj" "$scratch/scenes/notes.txt"
export PATH=$scratch/bin:$PATH HOME=$scratch/home
cd "$scratch"
faults=0 cases=0

# Each of these prints the words that may follow the command line of its arguments, the last of which is completed.
in_bash() {
  bash --norc -c 'source "$0"; COMP_WORDS=(malha "$@") COMP_CWORD=$#; _malha; printf "%s\n" "${COMPREPLY[@]}"' \
    "$scripts/malha.bash" "$@"
}
in_zsh() { # with the builtin that takes the words replaced by one that prints them
  zsh -f -c 'compadd() { local -a all; all=("${@[$(( ${@[(i)--]} + 1 )),-1]}"); print -rl -- "${all[@]}"; }
    words=(malha "$@") CURRENT=$(( $# + 1 )); source "$0"' "$scripts/_malha" "$@"
}
in_fish() {
  local line
  printf -v line '%s ' malha "${@:1:$#-1}"
  # shellcheck disable=SC2016  # fish expands it
  fish --no-config -c 'source $argv[1]; complete -C $argv[2]' "$scripts/malha.fish" "$line${*: -1}" | cut --fields 1
}
# check SHELL EXPECTED WORDS...: `malha WORDS...` may go on with the words of EXPECTED, in any order, folders with or
# without '/'.
check() {
  local shell=$1 expected=$2 found
  shift 2
  cases=$((cases + 1))
  found=$({ "in_$shell" "$@" || true; } | sed 's|/$||' | sort | paste --serial --delimiters ' ')
  [[ $found == "$expected" ]] && return
  printf '%s: malha %s: found "%s"; allowed: "%s"\n' "$shell" "$*" "$found" "$expected"
  faults=$((faults + 1))
}

shells=(bash)
for shell in zsh fish; do
  if command -v "$shell" >/dev/null; then shells+=("$shell"); else printf '%s: is not installed\n' "$shell"; fi
done
for shell in "${shells[@]}"; do
  check "$shell" 'run' ru
  check "$shell" 'page picture plan' p
  check "$shell" '--resume' run scenes/ball.json --res
  check "$shell" 'cuda openmp serial' run scenes/ball.json --backend ''
  check "$shell" 'serial' plan --backend s
  check "$shell" 'h100 h200' plan --for h
  check "$shell" 'vtp,pc2 vtp,ply' run --format vtp,p
  check "$shell" '' run --threads ''
  check "$shell" 'scenes/flag.json scenes/folder' run scenes/f
  check "$shell" 'scenes/a ball.json scenes/ball.json scenes/flag.json scenes/folder' check scenes/
  check "$shell" 'scenes' run --out sc
  check "$shell" '' check scenes/ball.json scenes/
  if [[ -x bin/malha_measures ]]; then
    check "$shell" 'filter' bench filt
    check "$shell" 'dense,sparse dense,step' bench filter --kernel dense,s
    check "$shell" 'scaling' study sc
    check "$shell" '--error' tune scenes/ball.json --e
  fi
  if [[ -x bin/malha_view ]]; then check "$shell" 'scenes/mesh.obj' view scenes/m; fi
done
check bash 'openmp' run --backend = o # bash takes "--backend=o" for three words
check bash 'cuda openmp serial' run --backend =
if [[ " ${shells[*]} " == *' zsh '* ]]; then
  registered=$(FPATH=$scripts:$(zsh -f -c 'print $FPATH') zsh -f -c 'autoload -Uz compinit && compinit -D -u && print -r -- $_comps[malha]')
  [[ $registered == _malha ]] || { printf 'zsh: found "%s" for malha; allowed: _malha\n' "$registered"; faults=$((faults + 1)); }
fi

printf '%d cases in %s, %d faults\n' "$cases" "${shells[*]}" "$faults"
((faults == 0))
