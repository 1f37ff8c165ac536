# SPDX-License-Identifier: Apache-2.0
"""A gallery of both methods: one cloth, at the same times, by XPBD and by Desbrun's filter.

The filter as published damps motion that its steps do not resolve: the cloth sinks instead of swinging. Further solves of the
same filter ("refinement_iterations") lead to backward Euler.
"""
import argparse

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

import malha

TIMES = (0.0, 0.2, 0.4, 0.8, 1.6)  # s
METHODS = {
    "XPBD, 10 substeps": {"type": "pbd", "substeps": 10},
    "Desbrun 1999, 1 substep": {"type": "desbrun", "substeps": 1},
    "the same, refined 40 times": {"type": "desbrun", "substeps": 1, "refinement_iterations": 40},
}


def cloth(solver):
    return {
        "name": "cloth", "gravity": [0, -9.81, 0], "duration": 2,
        "solver": {"dt": 1 / 60, "iterations": 1} | solver,
        "bodies": [{"name": "cloth", "mass": 0.3, "pins": [{"particles": [0, 20]}],
                    "constraints": [{"type": "distance", "elements": ["edges", "shear"], "compliance": 1e-3}],
                    "shape": {"grid": {"size": [1, 1], "cells": [20, 20]}}}]}


def draw(axes, simulation, turn=np.radians(35), lift=np.radians(20)):
    """Draws the triangles from the side and from above, far ones first, coloured by height."""
    x, y, z = simulation.positions.T
    near = np.cos(turn) * z - np.sin(turn) * x
    seen = np.stack([np.cos(turn) * x + np.sin(turn) * z, np.cos(lift) * y - np.sin(lift) * near], axis=1)
    order = np.argsort(near[simulation.triangles].mean(axis=1))
    triangles = simulation.triangles[order]
    cloth = PolyCollection(seen[triangles], array=y[triangles].mean(axis=1), cmap="viridis", clim=(-1, 0),
                           edgecolor="black", linewidth=0.15)
    axes.add_collection(cloth)
    axes.set(xlim=(-0.5, 1.45), ylim=(-1.15, 0.4), aspect="equal")
    axes.set_axis_off()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--out", default="gallery.png")
    out = arguments.parse_args().out
    figure, all_axes = plt.subplots(len(METHODS), len(TIMES), figsize=(2.2 * len(TIMES), 2.1 * len(METHODS)),
                                    constrained_layout=True)
    for row, (name, solver) in enumerate(METHODS.items()):
        simulation = malha.Simulation(cloth(solver))
        for column, time in enumerate(TIMES):
            simulation.step(int(np.round(time * 60)) - simulation.steps)
            axes = all_axes[row, column]
            draw(axes, simulation)
            axes.set_title(f"{name}\n{time} s" if column == 0 else f"{time} s", fontsize=9)
        measured = simulation.measure()
        print(f"{name}: kinetic energy {measured['kinetic_energy_j']:.4f} J after {simulation.time:.1f} s, "
              f"strain up to {measured['strain_max']:.3f}")
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
