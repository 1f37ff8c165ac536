# SPDX-License-Identifier: Apache-2.0
"""A mesh that numpy moves: a wave runs through a mat, and a cloth that lies on it rides on its crests.

The vertices of the mat are set before every step. The chart has the cloth's mean height and the mat's under it over time, and a
cut through both at the end.
"""
import argparse

import matplotlib.pyplot as plt
import numpy as np

import malha

CELLS, LENGTH, WIDTH = (60, 12), 3.0, 0.6  # of the mat, m
HEIGHT, SPEED, WAVES = 0.12, 0.8, 2 * np.pi / 1.2  # m, m/s, 1/m
DT = 1 / 60  # s


def mat():
    """Points (V, 3) and faces of the mat at rest."""
    x, z = np.meshgrid(np.linspace(0, LENGTH, CELLS[0] + 1), np.linspace(-WIDTH / 2, WIDTH / 2, CELLS[1] + 1))
    points = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    row = CELLS[0] + 1
    corner = (np.arange(CELLS[1])[:, None] * row + np.arange(CELLS[0])).ravel()
    return points, np.stack([corner, corner + row, corner + row + 1, corner + 1], axis=1)


def waved(points, time):
    """The mat at a time: a wave that begins softly."""
    high = HEIGHT * min(time / 1.0, 1.0)
    moved = points.copy()
    moved[:, 1] = high * np.sin(WAVES * (points[:, 0] - SPEED * time))
    return moved


def scene(points, faces):
    cloth = {"name": "cloth", "shape": {"grid": {"size": [0.8, 0.4], "cells": [24, 12]}}, "mass": 0.1, "damping": 0.02,
             "transform": {"translate": [1.1, 0.02, -0.2]},
             "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]}
    return {"name": "swimmer", "gravity": [0, -9.81, 0], "duration": 4, "bodies": [cloth],
            "solver": {"type": "pbd", "dt": DT, "substeps": 10},
            "environment": [{"name": "mat", "shape": malha.shape(points, faces), "sides": "one_sided", "friction": 0.8,
                             "thickness": 0.01, "animation": {"from_code": True}}]}


def swim(steps=240):
    """Steps the scene; returns times, mean heights of the cloth, heights of the mat under it, and the last state."""
    points, faces = mat()
    simulation = malha.Simulation(scene(points, faces))
    times, cloth, under = [], [], []
    for step in range(1, steps + 1):
        simulation.set_vertices("mat", waved(points, step * DT))
        simulation.step()
        x = simulation.positions
        times.append(simulation.time), cloth.append(x[:, 1].mean()), under.append(waved(x, simulation.time)[:, 1].mean())
    return np.array(times), np.array(cloth), np.array(under), simulation


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--out", default="swimmer.svg")
    out = arguments.parse_args().out
    times, cloth, under, simulation = swim()
    above = simulation.positions[:, 1] - waved(simulation.positions, simulation.time)[:, 1]
    print(f"the cloth is {1000 * (cloth - under).mean():.0f} mm above the mat on average, "
          f"its lowest particle {1000 * above.min():.0f} mm at the end")
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), constrained_layout=True)
    left.plot(times, cloth, label="cloth"), left.plot(times, under, label="mat under it")
    left.set(xlabel="time (s)", ylabel="mean height (m)"), left.legend()
    x, y, _ = simulation.positions[6 * 25:7 * 25].T  # the middle row
    line = waved(np.linspace([0, 0, 0], [LENGTH, 0, 0], 200), simulation.time)
    right.plot(line[:, 0], line[:, 1], label="mat"), right.plot(x, y, ".-", label="cloth")
    right.set(xlabel="x (m)", ylabel="height (m)", ylim=(-0.3, 0.4)), right.legend(ncols=2)
    figure.savefig(out)


if __name__ == "__main__":
    main()
