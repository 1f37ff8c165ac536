#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: same_bits.sh MALHA OTHER
# Runs the first steps of every shipped scene by two builds of the command: their states must have the same bits.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
malha=${1:?usage: same_bits.sh MALHA OTHER} other=${2:?usage: same_bits.sh MALHA OTHER}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

hash_by() { # COMMAND SCENE
  "$1" run "$2" --steps 10 --every 0 --no-picture --no-page --checkpoint 0 --quiet --out "$out/run" 2>"$out/said" >&2 ||
    { cat "$out/said" >&2; return 1; }
  sed -n 's/.*"state_hash": "\(.*\)".*/\1/p' "$out/run/report.json"
}

faults=0 count=0
for scene in scenes/*.json; do
  [[ $scene == scenes/schema.json ]] && continue
  one=$(hash_by "$malha" "$scene") two=$(hash_by "$other" "$scene")
  if [[ -z $one || $one != "$two" ]]; then
    echo "$scene: found $one by $malha and $two by $other; allowed: the same"
    faults=$((faults + 1))
  fi
  count=$((count + 1))
done
echo "$count scenes, $faults faults"
((count > 0 && faults == 0))
