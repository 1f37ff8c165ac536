# SPDX-License-Identifier: Apache-2.0
"""The type stubs say what the module has, and everything in it is documented."""
import ast
import inspect
import re
import subprocess
import sys

import pytest
from conftest import ROOT

import malha

STUBS = ast.parse((ROOT / "tools" / "python" / "malha-stubs" / "__init__.pyi").read_text())


def parameters(function):
    """Names and, as text, defaults, in order; '*' before those that are given by name."""
    args = function.args
    names = [(a.arg, None) for a in args.posonlyargs + args.args]
    for place, default in enumerate(reversed(args.defaults), 1):
        names[-place] = names[-place][0], ast.unparse(default)
    if args.kwonlyargs:
        names.append(("*", None))
    names += [(a.arg, d and ast.unparse(d)) for a, d in zip(args.kwonlyargs, args.kw_defaults)]
    return names + ([("**" + args.kwarg.arg, None)] if args.kwarg else [])


def documented(function):
    """The same tuple, from the signature that pybind11 writes at the head of a docstring, or that Python knows."""
    if inspect.isfunction(function):
        names = []
        for one in inspect.signature(function).parameters.values():
            if one.kind is one.KEYWORD_ONLY and ("*", None) not in names:
                names.append(("*", None))
            names.append((one.name, None if one.default is one.empty else repr(one.default)))
        return names
    line = function.__doc__.splitlines()[0]
    inside = line[line.index("(") + 1 : line.rindex(") ->")]
    names = []
    for part in re.split(r", (?=[\w*]+(?::|$|,))", inside):
        name, _, default = part.partition(" = ")
        names.append((name.split(":")[0], default or None))
    return names


def same(stub, function):
    def plain(text):
        return None if text is None else text.replace('"', "'").replace("1e-4", "0.0001")

    there = [(name, plain(default)) for name, default in documented(function)]
    return [(name, plain(default)) for name, default in parameters(stub)] == [
        ("**more" if name.startswith("**") else name, default) for name, default in there
    ]


CLASSES = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}


def members(cls):
    hidden = {"__init__", "__len__"}
    return {name for name, value in vars(cls).items()
            if (not name.startswith("_") or (name in hidden and name in vars(cls)))
            and not (name == "__init__" and "Raises TypeError" in str(value.__doc__))}


def test_the_stubs_name_everything():
    public = {name for name in dir(malha) if not name.startswith("_")}
    assert public == CLASSES.keys() | FUNCTIONS.keys()


@pytest.mark.parametrize("name", ["Scene", "Constraint", "Body", "Simulation"])
def test_a_class_has_the_members_of_its_stub(name):
    cls = getattr(malha, name)
    stubbed = {node.name for node in CLASSES[name].body if isinstance(node, ast.FunctionDef)}
    found = members(cls) - ({"__init__"} if name == "Body" else set())
    assert found == stubbed
    for node in CLASSES[name].body:
        decorators = [ast.unparse(d) for d in node.decorator_list]
        member = getattr(cls, node.name)
        if decorators == ["property"]:
            assert isinstance(member, property), node.name
        elif decorators:
            assert member.fset is not None, node.name
        elif node.name != "__len__":
            assert same(node, member), (node.name, parameters(node), documented(member))
    settable = {n for n in stubbed if isinstance(getattr(cls, n), property) and getattr(cls, n).fset}
    assert settable == {n.name for n in CLASSES[name].body if len(n.decorator_list) and "setter" in ast.unparse(n.decorator_list[0])}


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_a_function_has_the_parameters_of_its_stub(name):
    assert same(FUNCTIONS[name], getattr(malha, name)), (parameters(FUNCTIONS[name]), documented(getattr(malha, name)))


@pytest.mark.parametrize("name", ["InputError", "OutOfMemory", "Diverged"])
def test_an_error_has_the_bases_of_its_stub(name):
    bases = [getattr(malha, b, None) or getattr(__builtins__, b, None) or __builtins__[b]
             for b in map(ast.unparse, CLASSES[name].bases)]
    assert list(getattr(malha, name).__bases__) == bases


def test_everything_is_documented():
    for name in dir(malha):
        thing = getattr(malha, name)
        if name.startswith("_"):
            continue
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for member in members(thing) - {"__len__", "__init__"}:
                said = inspect.getdoc(getattr(thing, member)) or ""
                assert len(said.splitlines()[-1]) > 1, (name, member)


def mypy_of(tmp_path, *lines):
    """What mypy says of a program."""
    pytest.importorskip("mypy", reason="mypy is missing; tools/setup python installs it")
    file = tmp_path / "program.py"
    file.write_text("import malha\nimport numpy as np\nimport numpy.typing as npt\n" + "\n".join(lines) + "\n")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(file)],
                          capture_output=True, text=True, check=False, cwd=tmp_path)
    return done.stdout


def test_mypy_reads_the_stubs(tmp_path):
    assert "Success" in mypy_of(
        tmp_path, 'simulation = malha.Simulation(malha.Scene("flag.json"), threads=2)',
        "lowest = simulation.positions[:, 1].min()", "simulation.positions = np.zeros((3, 3))",
        'table = malha.sweep("flag.json", {"/solver/substeps": [10, 20]}, out="sweep")',
        "corners: npt.NDArray[np.int32] = simulation.faces")


def test_mypy_finds_a_wrong_shape_and_a_wrong_keyword(tmp_path):
    said = mypy_of(tmp_path, 'simulation = malha.Simulation("flag.json", thread=2)',
                   "flat: np.ndarray[tuple[int], np.dtype[np.float64]] = simulation.positions")
    assert 'Unexpected keyword argument "thread"' in said
    assert re.search(r"program.py:5: error: Incompatible types in assignment", said), said
