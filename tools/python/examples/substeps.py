# SPDX-License-Identifier: Apache-2.0
"""Error against substeps of a user's scene: how many substeps does it need, and does XPBD converge?

A chain of ten links of 0.1 m, pinned at one end, is released level. The reference is the same scene with 2,560 substeps.
"""
import argparse

import matplotlib.pyplot as plt
import numpy as np

import malha


def chain(substeps, compliance):
    kind = {"type": "distance"} | ({"compliance": compliance} if compliance else {"stiffness": 1})
    return {
        "name": "chain", "gravity": [0, -9.81, 0], "duration": 0.3,
        "solver": {"type": "pbd", "dt": 1 / 60, "substeps": substeps, "iterations": 1, "precision": "double"},
        "bodies": [{"name": "chain", "mass": 0.5, "pins": [{"row": "first"}], "constraints": [kind],
                    "shape": {"chain": {"from": [0, 0, 0], "to": [1, 0, 0], "segments": 10}}}]}


def end_of(substeps, compliance):
    simulation = malha.Simulation(chain(substeps, compliance), threads=1)
    simulation.step(18)
    return simulation.positions


def errors(compliance, counts, truth=2560):
    """The largest distance (m) of a particle from the reference solution after 0.3 s."""
    right = end_of(truth, compliance)
    return [np.linalg.norm(end_of(n, compliance) - right, axis=1).max() for n in counts]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--out", default="substeps.svg")
    out = arguments.parse_args().out
    counts = 5 * 2 ** np.arange(8)
    figure, axes = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
    for compliance, name in ((0, "stiff"), (1e-3, "compliance 1e-3 m/N"), (1e-2, "compliance 1e-2 m/N")):
        error = errors(compliance, counts)
        order = -np.polyfit(np.log(counts[2:]), np.log(error[2:]), 1)[0]
        axes.loglog(counts, error, "o-", label=f"{name}: order {order:.2f}")
        print(f"{name}: {error[0]:.3g} m with {counts[0]} substeps, {error[-1]:.3g} m with {counts[-1]}, order {order:.2f}")
    axes.set(xlabel="substeps of a step of 1/60 s", ylabel="largest error after 0.3 s (m)",
             title="A chain of ten links, released level")
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    figure.savefig(out)


if __name__ == "__main__":
    main()
