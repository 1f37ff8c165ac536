#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: device_memory.sh TESTS SANITIZER
# Runs scenes on a CUDA device under NVIDIA's Compute Sanitizer: no access out of bounds, no race in shared memory.
# Exits 77 (skipped) where there is no sanitizer or no device.
set -euo pipefail
tests=${1:?usage: device_memory.sh TESTS SANITIZER}
sanitizer=${2-}
if ! command -v "$sanitizer" >/dev/null || ! nvidia-smi --list-gpus 2>/dev/null | grep --quiet GPU; then
  echo "skipped: no Compute Sanitizer, or no device"
  exit 77
fi
filter=
for scene in flag balloon desbrun_sheet folded_sheet rotating_sphere ramp thin_wall; do filter+="SceneOnCuda.*/$scene:"; done
for tool in memcheck racecheck; do
  "$sanitizer" --tool "$tool" --error-exitcode 1 "$tests" --gtest_brief=1 --gtest_filter="$filter"
done
