# SPDX-License-Identifier: Apache-2.0
"""Helpers for tests of the Python module. tests/python.sh sets the paths of the module and of the command."""
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import malha

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "study"))  # the scripts of the studies are modules, too
COMMAND = os.environ["MALHA_COMMAND"]
G = 9.81


def scene_of(*bodies, gravity=(0, -G, 0), dt=0.01, substeps=8, iterations=1, precision="double", **more):
    solver = {"type": "pbd", "dt": dt, "substeps": substeps, "iterations": iterations, "precision": precision}
    return {"name": "small", "solver": solver | more.pop("solver", {}), "gravity": list(gravity),
            "bodies": list(bodies), "duration": 1} | more


def cloth(name="cloth", cells=12, x=0.0, **more):
    return {"name": name, "shape": {"grid": {"size": [1, 1], "cells": [cells, cells]}}, "mass": 0.2,
            "transform": {"translate": [x, 0, 0]}, "pins": [{"particles": [0, cells]}],
            "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]} | more


def chain(links=1, length=0.5, constraints=()):
    """A horizontal chain; a single link has 1 kg at its end."""
    return {"name": "chain", "shape": {"chain": {"from": [0, 0, 0], "to": [length * links, 0, 0], "segments": links}},
            "mass": 2 if links == 1 else links + 1, "pins": [{"row": "first"}], "constraints": list(constraints)}


def distance(rest):
    """The function |x1 - x0| - rest of a malha.Constraint."""

    def function(x, which):
        along = x[:, 1] - x[:, 0]
        length = np.linalg.norm(along, axis=1)
        n = along / length[:, None]
        return length - (rest[which] if np.ndim(rest) else rest), np.stack([-n, n], axis=1)

    return function


def said_by_command(*words, cwd=None):
    """The command's exit status and its standard error without the final line break."""
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=cwd, check=False)
    return done.returncode, done.stderr.rstrip("\n")


def run_study(name, *words):
    """The script of a study that has run with these words."""
    return subprocess.run([sys.executable, ROOT / "tools" / "study" / f"{name}.py", *map(str, words)], capture_output=True,
                          text=True, check=False)


def quick_study(name, make_folder):
    """The folder of the results of a quick run of a study. make_folder: tmp_path_factory.mktemp."""
    out = make_folder(name)
    ended = run_study(name, "--quick", "--out", out)
    assert ended.returncode == 0, ended.stderr
    return out


@pytest.fixture
def rushing():
    """A particle that exceeds the largest float, 2^128, at the 1024th step."""
    at = {"lattice": {"min": [0, 1, 0], "max": [0, 1, 0], "count": [1, 1, 1]}}
    return {"name": "rush", "solver": {"type": "pbd", "dt": 2.0**59, "substeps": 1},
            "bodies": [{"name": "rushing", "shape": at, "mass": 1, "velocity": [2.0**59, 0, 0]}], "duration": 2.0**59}


@pytest.fixture
def simulation():
    return malha.Simulation(scene_of(cloth()), threads=1)
