#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: desktop.sh ROOT
# The desktop entry of the window is valid, and its icon is an SVG picture of the name that the entry gives it.
set -euo pipefail
cd "${1:?usage: desktop.sh ROOT}/tools/package"
command -v desktop-file-validate >/dev/null || { echo "skipped: desktop-file-validate is not installed (desktop-file-utils)"; exit 77; }
said=$(desktop-file-validate malha.desktop) || { printf '%s\n' "$said"; exit 1; }
[[ -z $said ]] || { printf '%s\n' "$said"; exit 1; }
icon=$(sed -n 's/^Icon=//p' malha.desktop)
grep --quiet '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 128 128"' "$icon.svg" || { echo "$icon.svg: found no SVG"; exit 1; }
command -v xmllint >/dev/null && xmllint --noout "$icon.svg"
[[ $(sed -n 's/^Exec=\([^ ]*\) .*/\1/p' malha.desktop) == malha ]] || { echo "Exec: found another program than malha"; exit 1; }
