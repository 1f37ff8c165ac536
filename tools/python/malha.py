# SPDX-License-Identifier: Apache-2.0
"""Deformable bodies by Position Based Dynamics with XPBD's compliance, and by Desbrun's method. SI units.

A Scene says what is simulated, a Simulation steps through it, and arrays are numpy's. sweep() runs many scenes, on one
machine or on many; tune() and study() are the commands `malha tune` and `malha study`.
"""
import concurrent.futures as _futures
import difflib as _difflib
import fcntl as _fcntl
import functools as _functools
import glob as _glob
import hashlib as _hashlib
import inspect as _inspect
import itertools as _itertools
import json as _json
import os as _os
import pathlib as _pathlib
import shutil as _shutil
import subprocess as _subprocess
import sys as _sys
import tempfile as _tempfile

from _malha import (Body, Constraint, Diverged, InputError, OutOfMemory, Scene, Simulation, __version__, body, run,
                    shape)

__all__ = ["Body", "Constraint", "Diverged", "InputError", "OutOfMemory", "Scene", "Simulation", "body", "run", "shape",
           "study", "sweep", "tune"]


def __dir__():
    return [*__all__, "__doc__", "__file__", "__name__", "__version__"]


def _did_you_mean(word, allowed):
    near = _difflib.get_close_matches(word, allowed, 1)
    return f" (did you mean '{near[0]}'?)" if near else ""


def _briefly(function):
    """Answers a keyword that the function does not have as the extension's functions do."""
    allowed = list(_inspect.signature(function).parameters)

    @_functools.wraps(function)
    def call(*given, **named):
        for word in named:
            if word not in allowed:
                raise TypeError(f"{function.__name__}: found the keyword '{word}'{_did_you_mean(word, allowed)}; allowed: "
                                + ", ".join(allowed))
        return function(*given, **named)

    return call


def _table(rows):
    """The rows as a pandas DataFrame, or unchanged where pandas is not installed."""
    try:
        import pandas
    except ImportError:
        return rows
    return pandas.DataFrame(rows)


# ---- The command -----------------------------------------------------------------------------------------------------


def _command():
    """The command `malha` of this version: beside the module in a build and in a wheel, in bin/ of the prefix where the
    module was installed, or on the PATH."""
    here = _pathlib.Path(__file__).resolve().parent
    places = [here / "malha", here / "malha.libs" / "malha"]
    if len(here.parents) > 2:
        places.append(here.parents[2] / "bin" / "malha")
    places.append(_shutil.which("malha"))
    for place in places:
        if place and _os.access(place, _os.X_OK) and not _os.path.isdir(place):
            version = _subprocess.run([place, "--version"], capture_output=True, text=True, check=False).stdout
            if version.split() == ["malha", __version__]:
                return str(place)
    raise RuntimeError(f"malha {__version__}: found no command of this version; allowed: one beside {__file__}, below the "
                       "same prefix or on the PATH")


def _main():
    """The console script of a wheel: becomes the command."""
    command = _command()
    _os.execve(command, [command, *_sys.argv[1:]], _environment())


def _environment():
    """The environment of the command, whose studies this Python runs."""
    return {**_os.environ, "MALHA_PYTHON": _sys.executable} if _sys.executable else dict(_os.environ)


def _called(words, named):
    """Runs the command to its end. Raises what its exit status says; a file's path in a message becomes its name."""
    done = _subprocess.run([_command(), *map(str, words)], capture_output=True, text=True, check=False,
                           stdin=_subprocess.DEVNULL, env=_environment())
    said = done.stderr.strip()
    for path, name in named.items():
        said = said.replace(str(path), name)
    if done.returncode:
        error = {2: InputError, 3: Diverged, 5: OutOfMemory}.get(done.returncode, RuntimeError)
        raise error(said or f"malha {words[0]} ended with status {done.returncode}")
    return done.stdout


@_briefly
def tune(scene, *, error, seconds=None, threads=0):
    """The cheapest method and settings that keep all particles within an error, as `malha tune` finds them.

    scene: a Scene, or what makes one. error: RMS distance (m) to the true motion, at the worst of four moments.
    seconds: simulated time over which it is measured; the scene's duration, but at most 1 s, by default. threads: 0 for
    as many as there are. The command runs in a process of its own, because it measures times.

    Returns a dict: "scene", the tuned Scene; "trials", a table (pandas where it is installed, otherwise a list of dicts)
    of all settings that were tried, with ms_per_s, error_m and whether they reach the error; "best", the row of the
    scene; and what else `malha tune --json` writes. Raises InputError, and RuntimeError where nothing reaches the error
    or the motion has no reference.
    """
    with _tempfile.TemporaryDirectory() as folder:
        given, tuned, trials = (_pathlib.Path(folder, name) for name in ("scene.json", "tuned.json", "trials.json"))
        given.write_text((scene if isinstance(scene, Scene) else Scene(scene)).to_json())
        words = ["tune", given, "--error", repr(float(error))]
        words += ["--threads", threads] if threads else []
        words += ["--seconds", repr(float(seconds))] if seconds is not None else []
        _called([*words, "--out", tuned, "--json", trials], {given: "scene"})
        found = _json.loads(trials.read_text())
        return found | {"trials": _table(found["trials"]), "scene": Scene(tuned)}


@_briefly
def study(name, *, quick=False, out=None):
    """A study of methods, as by `malha study`: "accuracy", "stability", "scaling", "size", "parsimony", "published",
    "validation".

    quick: smaller cases and fewer points, which take seconds instead of minutes. out: the folder of the results;
    "out/study", or "out/study_quick", by default. An interrupted study goes on where the same folder is named. Studies
    need scipy and matplotlib.

    Returns a dict: "rows", a table (pandas where it is installed, otherwise a list of dicts) of all that was measured;
    "sections", their titles, sentences and charts; "page", the page that shows them; and what else NAME.json in the
    folder holds. Raises InputError for a name that is no study's.
    """
    if name in ("all", "results"):
        raise InputError(f"study: found '{name}'; allowed: the name of one study")
    out = _pathlib.Path(out if out is not None else _pathlib.Path("out", "study_quick" if quick else "study"))
    _called(["study", name, "--out", out] + (["--quick"] if quick else []), {})
    found = _json.loads((out / f"{name}.json").read_text())
    return found | {"rows": _table(found["rows"]), "page": str(out / "index.html")}


# ---- The sweep -------------------------------------------------------------------------------------------------------


def _rows_of(parameters):
    """The parameters of each run: all combinations of a dict's lists, or a list's dicts."""
    if hasattr(parameters, "to_dict") and hasattr(parameters, "columns"):  # a DataFrame
        return parameters.to_dict("records")
    if isinstance(parameters, dict):
        for path, values in parameters.items():
            if isinstance(values, str) or not hasattr(values, "__iter__"):
                raise InputError(f"sweep: parameters: {path}: found {type(values).__name__}; allowed: a list of values")
        return [dict(zip(parameters, values)) for values in _itertools.product(*parameters.values())]
    rows = list(parameters)
    for number, row in enumerate(rows):
        if not isinstance(row, dict):
            raise InputError(f"sweep: parameters: row {number}: found {type(row).__name__}; allowed: a dict of values")
    return rows


def _set(scene, path, value):
    """Sets the value at a path such as /bodies/0/mass of a scene's dict; in a list a name stands for a number."""
    words = path.strip("/").split("/")
    here = scene
    for depth, word in enumerate(words):
        if isinstance(here, list):
            names = [one.get("name") if isinstance(one, dict) else None for one in here]
            allowed = [str(number) for number in range(len(here))] + [name for name in names if name]
            found = names.index(word) if word in names else int(word) if word.isdecimal() and int(word) < len(here) else None
        else:
            allowed = list(here) if isinstance(here, dict) else []
            found = word if isinstance(here, dict) and (word in here or depth == len(words) - 1) else None
        if found is None:
            raise InputError(f"sweep: parameters: {path}: found '{word}'{_did_you_mean(word, allowed)}; allowed: "
                             + (", ".join(allowed) or "nothing below a number"))
        if depth == len(words) - 1:
            here[found] = value
        else:
            here = here[found]


def _scene_of(scene, row, folder):
    """The scene of a run: the base with the row's values in their places, or what the function makes of them. Relative
    paths start from the folder, whichever process asks."""
    if callable(scene):
        made = scene(**row)
        return Scene(made.to_dict() if isinstance(made, Scene) else made, folder=folder if isinstance(made, (Scene, dict)) else None)
    values = scene.to_dict()
    for path, value in row.items():
        _set(values, path, value)
    return Scene(values, folder=folder)


_digests = {}  # of files, by path, size and time: many runs share a mesh


def _digest(path):
    at = _os.stat(path)
    key = path, at.st_size, at.st_mtime_ns
    if key not in _digests:
        _digests[key] = _hashlib.sha256(_pathlib.Path(path).read_bytes()).hexdigest()
    return _digests[key]


def _files_in(value):
    """The files that a scene's dict names, which has absolute paths: of files, of folders, or with a '*'."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [path for one in value if isinstance(one, (dict, list, str)) for path in _files_in(one)]
    found = _glob.glob(value) if isinstance(value, str) and value.startswith("/") else []
    return [path for one in found for path in ([one] if _os.path.isfile(one) else _glob.glob(_os.path.join(one, "*")))
            if _os.path.isfile(path)]


def _name_of(scene, steps):
    """The folder's name: a hash of the scene, of the files that it names, of the steps and of malha's version."""
    text = scene.to_json()
    files = sorted({_digest(path) for path in _files_in(_json.loads(text))})
    return _hashlib.sha256(_json.dumps([text, files, steps, __version__]).encode()).hexdigest()[:16]


def _flat(measures, before=""):
    """The numbers and words of a dict, without its lists; names of dicts within it are joined by dots."""
    for name, value in measures.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}.")
        elif not isinstance(value, list):
            yield before + name, value


def _measures_in(folder):
    """What the table says of a run that is done."""
    report = _json.loads((folder / "report.json").read_text())
    return {"status": report["status"], "steps": report["step"], "time_s": report["time_s"],
            **dict(_flat(report.get("state", {}))), "state_hash": report.get("state_hash"),
            "step_ms_median": report["timing"]["step_ms_median"], "warnings": len(report["warnings"]),
            "notes": "; ".join(report["notes"])}


def _sweep_one(scene, row, paths_from, folder, options):
    """Makes one run of a sweep, unless it is there; returns what the table says of it. It is written beside its folder
    and then renamed, so that a folder is whole or not there. Who comes second waits until the first is done or dead."""
    folder = _pathlib.Path(folder)
    part, lock = (folder.with_name(folder.name + end) for end in (".part", ".lock"))
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with open(lock, "w") as held:
            _fcntl.flock(held, _fcntl.LOCK_EX)
            if not folder.is_dir():
                _run_part(_scene_of(scene, row, paths_from), part, options)
                _os.rename(part, folder)
            lock.unlink(missing_ok=True)  # only where the folder is there: who waits at the lock finds it
        return _measures_in(folder)
    except InputError as error:
        _shutil.rmtree(part, ignore_errors=True)
        return {"status": "refused", "notes": str(error)}
    except (OSError, RuntimeError) as error:
        return {"status": "failed", "notes": f"{type(error).__name__}: {error}"}


def _run_part(scene, part, options):
    """The run itself; from its checkpoint where it was killed. What diverges leaves its report, too."""
    resume = (part / "checkpoint.malha").exists()
    try:
        try:
            run(scene, part, resume=resume, **options)
        except InputError:
            if not resume:
                raise
            run(scene, part, **options)  # it was killed after its last step
    except Diverged:
        pass


def _submit_of(executor):
    """The executor's function submit."""
    if hasattr(executor, "get_executor"):  # Dask's Client
        executor = executor.get_executor(pure=False)
    if not callable(getattr(executor, "submit", None)):
        raise InputError(f"sweep: executor: found {type(executor).__name__}; allowed: one of concurrent.futures, such as "
                         "ProcessPoolExecutor, mpi4py's MPIPoolExecutor, or Dask's Client")
    context = getattr(executor, "_mp_context", None)  # of a ProcessPoolExecutor
    if context is not None and context.get_start_method() == "fork":
        raise InputError("sweep: executor: found processes that are forked, in which OpenMP may hang; allowed: "
                         'ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))')
    return executor.submit


@_briefly
def sweep(scene, parameters, executor=None, *, out="out/sweep", steps=None, threads=1, backend="openmp", progress=None):
    """Many runs of a scene, each once, by any executor; returns a table of their parameters, measures and folders.

    scene: a Scene, or what makes one, as the base; or a function that returns it for the parameters of a run, which it
    is given by name. parameters: a dict of lists, of which all combinations are run, or a list of dicts (or a DataFrame),
    one a run. Their names are places in the scene, as messages and scenes have them: "/solver/substeps",
    "/bodies/0/mass" or "/bodies/NAME/mass".

    executor: one of concurrent.futures, such as ProcessPoolExecutor (its processes must be spawned, not forked), mpi4py's
    MPIPoolExecutor, or a Dask Client; none: one run after the other, here. On several machines the folder out and the
    mesh files are where all of them find them, and each has this module.

    Each run is that of run(), in the folder out/HASH. It is written beside it, as HASH.part, and then renamed, so that
    what is there is whole. The hash is that of the scene with all its values, of the files that it names, of the steps
    and of malha's version: a sweep that was killed goes on where it is called again, also with more parameters, and
    makes only what is missing; a long run goes on from its checkpoint.

    steps: fewer than the scene's duration has. threads: of each run; the bits are the same for any number.
    progress(done, runs) is called after each run.

    Returns a pandas DataFrame, or a list of dicts where pandas is not installed: the parameters, "status" ("finished",
    "diverged", "refused" where the scene cannot be simulated, "failed" where something else went wrong), the measures
    of "state" in report.json by their names there, "state_hash", "notes" (why it was refused or diverged, and which
    expectations failed) and "path". Refused and failed runs leave no folder, and are tried again by the next call.
    Raises InputError, before the first run, for parameters that no scene has; and RuntimeError where the executor ends
    before all runs are done: call it again with a new one.
    """
    rows = _rows_of(parameters)
    if not callable(scene) and not isinstance(scene, Scene):
        scene = Scene(scene)
    paths_from = _os.getcwd()
    submit = _submit_of(executor) if executor is not None else None
    out = _pathlib.Path(out).resolve()
    folders = []
    for number, row in enumerate(rows):
        try:
            folders.append(str(out / _name_of(_scene_of(scene, row, paths_from), steps)))
        except InputError as error:
            raise InputError(str(error) if str(error).startswith("sweep: ") else f"sweep: run {number}, {row}: {error}") from None
    first = {}  # in the order of the rows; equal scenes are run once
    for folder, row in zip(folders, rows):
        first.setdefault(folder, row)
    found = {folder: _measures_in(_pathlib.Path(folder)) for folder in first if _os.path.isdir(folder)}
    options = {"steps": steps, "threads": threads, "backend": backend}
    lost = None

    def keep(folder, said):
        found[folder] = said
        if progress:
            progress(len(found), len(first))

    todo = {folder: row for folder, row in first.items() if folder not in found}
    if submit is None:
        for folder, row in todo.items():
            keep(folder, _sweep_one(scene, row, paths_from, folder, options))
    else:
        futures = {}
        try:
            for folder, row in todo.items():
                futures[submit(_sweep_one, scene, row, paths_from, folder, options)] = folder
            for future in _futures.as_completed(futures):
                try:
                    said = future.result()
                except (Exception, _futures.CancelledError) as error:  # a worker that was killed; others go on
                    lost = error
                else:
                    keep(futures[future], said)
        except _futures.BrokenExecutor as error:
            lost = error
        finally:
            for future in futures:
                future.cancel()
    if len(found) < len(first):
        raise RuntimeError(f"sweep: {len(found)} of {len(first)} runs are done; found {type(lost).__name__}: {lost}; allowed: "
                           "to call it again with a new executor, which makes only what is missing") from lost
    for folder in first:
        if _os.path.isdir(folder):
            _pathlib.Path(folder + ".lock").unlink(missing_ok=True)  # of who was killed after renaming
    return _table([row | found[folder] | {"path": folder if _os.path.isdir(folder) else None}
                   for row, folder in zip(rows, folders)])
