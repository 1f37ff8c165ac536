# SPDX-License-Identifier: Apache-2.0
"""A compliance fitted to a measured sag: which material sags like this?

A strip of cloth of 1 m hangs between two rows of pins. Given the depth of its middle, scipy finds the compliance.
"""
import argparse

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import malha

CELLS = 20


def strip(compliance):
    row = 2 * (CELLS + 1)  # particles are counted along x first: each end has two
    ends = [{"particles": [0, 1]}, {"particles": [row - 2, row - 1]}]
    return {
        "name": "strip", "gravity": [0, -9.81, 0], "duration": 3,
        "solver": {"type": "pbd", "dt": 1 / 60, "substeps": 20, "iterations": 1, "precision": "double"},
        "bodies": [{"name": "strip", "mass": 0.1, "damping": 0.1, "pins": ends,
                    "constraints": [{"type": "distance", "elements": ["edges"], "compliance": compliance}],
                    "shape": {"grid": {"size": [0.05, 1], "cells": [1, CELLS]}}}]}


def at_rest(compliance):
    simulation = malha.Simulation(strip(compliance), threads=1)
    for _ in range(400):
        simulation.step()
        simulation.velocities = 0.95 * simulation.velocities  # damps the swinging, so that it comes to rest
    return simulation.positions


def sag(compliance):
    """The sag of the middle, m."""
    return -at_rest(compliance)[:, 1].min()


def fit(measured):
    """The compliance (m/N) with this sag: its curve over logarithms is nearly straight, so brentq needs few runs."""
    exponent = brentq(lambda e: sag(10**e) - measured, -5, -1, xtol=1e-4)
    return 10**exponent


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--sag", type=float, default=0.12, help="m; default 0.12")
    arguments.add_argument("--out", default="fit.svg")
    given = arguments.parse_args()
    found = fit(given.sag)
    print(f"a sag of {given.sag} m: compliance {found:.4g} m/N; with it the strip sags {sag(found):.5f} m")
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    tried = np.logspace(-4.5, -1.5, 13)
    left.loglog(tried, [sag(c) for c in tried], "o-", color="tab:gray", label="simulated")
    left.loglog(found, given.sag, "s", color="tab:red", label=f"fitted: {found:.3g} m/N")
    left.set(xlabel="compliance (m/N)", ylabel="sag (m)", title="Sag over compliance: flat where substeps are too few")
    left.legend()
    for compliance, colour in ((found / 10, "tab:blue"), (found, "tab:red"), (found * 4, "tab:green")):
        x = at_rest(compliance)[::2]
        right.plot(x[:, 2], x[:, 1], ".-", color=colour, label=f"{compliance:.3g} m/N")
    right.axhline(-given.sag, color="black", linewidth=0.8, linestyle="--")
    right.set(xlabel="z (m)", ylabel="y (m)", ylim=(None, 0.06), title="The strip at rest (y is drawn larger)")
    right.legend(ncols=3, loc="upper center", fontsize=8)
    for axes in (left, right):
        axes.grid(which="both", alpha=0.3)
    figure.savefig(given.out)


if __name__ == "__main__":
    main()
