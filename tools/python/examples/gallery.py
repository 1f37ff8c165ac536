"""A gallery of both methods: one cloth, at the same times, by XPBD and by Desbrun's filter.

The filter as published damps what its steps do not resolve: the cloth sinks instead of swinging. Further solves of the
same filter ("refine") lead to backward Euler.
"""
import argparse

import matplotlib.pyplot as plt
import numpy as np

import malha

TIMES = (0.0, 0.2, 0.4, 0.8, 1.6)  # s
METHODS = {
    "XPBD, 10 substeps": {"type": "pbd", "substeps": 10},
    "Desbrun 1999, 1 substep": {"type": "desbrun", "substeps": 1},
    "the same, refined 40 times": {"type": "desbrun", "substeps": 1, "refine": 40},
}


def cloth(solver):
    return {
        "name": "cloth", "gravity": [0, -9.81, 0], "duration": 2,
        "solver": {"dt": 1 / 60, "iterations": 1} | solver,
        "bodies": [{"name": "cloth", "mass": 0.3, "pins": [{"particles": [0, 20]}],
                    "constraints": [{"type": "distance", "on": ["edges", "shear"], "compliance": 1e-3}],
                    "shape": {"grid": {"size": [1, 1], "cells": [20, 20]}}}]}


def draw(axes, simulation):
    x, y, z = simulation.positions.T
    axes.plot_trisurf(x, z, y, triangles=simulation.triangles, cmap="viridis", linewidth=0.1, edgecolor="black", alpha=0.95)
    axes.set(xlim=(0, 1), ylim=(-0.9, 1), zlim=(-1.1, 0.2))
    axes.set_box_aspect((1, 1.9, 1.3), zoom=1.15)
    axes.view_init(elev=12, azim=-50)
    axes.set_axis_off()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--out", default="gallery.png")
    out = arguments.parse_args().out
    figure = plt.figure(figsize=(2.4 * len(TIMES), 2.4 * len(METHODS)), constrained_layout=True)
    for row, (name, solver) in enumerate(METHODS.items()):
        simulation = malha.Simulation(cloth(solver))
        for column, time in enumerate(TIMES):
            simulation.step(int(np.round(time * 60)) - simulation.steps)
            axes = figure.add_subplot(len(METHODS), len(TIMES), row * len(TIMES) + column + 1, projection="3d")
            draw(axes, simulation)
            axes.set_title(f"{name}\n{time} s" if column == 0 else f"{time} s", fontsize=9)
        measured = simulation.measure()
        print(f"{name}: kinetic energy {measured['kinetic_energy_j']:.4f} J after {simulation.time:.1f} s, "
              f"strain up to {measured['strain_max']:.3f}")
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
