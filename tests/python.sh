#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: python.sh PYTHON FOLDER COMMAND TEST
# Runs tests/python/TEST with this Python, the module malha from FOLDER and this malha command. Skipped where the module
# was not built (PYTHON is empty) or pytest or numpy is missing.
set -euo pipefail
python=${1?usage: python.sh PYTHON FOLDER COMMAND TEST} folder=${2:?} command=${3:?} test=${4:?}
skip() {
  printf 'skipped: %s\n' "$*"
  exit 77
}
[[ -n "$python" ]] || skip "the Python module was not built; tools/setup python installs what it needs"
for package in pytest numpy; do
  "$python" -c "import $package" 2>/dev/null || skip "$python has no $package; tools/setup python installs it"
done
export PYTHONPATH=$folder MALHA_COMMAND=$command MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=1
exec "$python" -m pytest -q -rs -p no:cacheprovider "$(dirname "$0")/python/$test"
