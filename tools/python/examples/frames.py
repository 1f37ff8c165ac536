# SPDX-License-Identifier: Apache-2.0
"""Reading frames: a run writes points_NAME.pc2 (PointCache2) for each mesh, and numpy maps it without a copy."""
import argparse
import pathlib

import matplotlib.pyplot as plt
import numpy as np

import malha

HEADER = np.dtype([("signature", "S12"), ("version", "<i4"), ("points", "<i4"), ("first", "<f4"), ("rate", "<f4"),
                   ("samples", "<i4")])


def read_pc2(path):
    """Positions by frame: float32 (frames, vertices, 3), m. Vertices are those of the mesh, unused ones too."""
    header = np.fromfile(path, HEADER, count=1)[0]
    if header["signature"] != b"POINTCACHE2":
        raise ValueError(f"{path}: found {header['signature']!r}; allowed: a PointCache2 file")
    shape = int(header["samples"]), int(header["points"]), 3
    return np.memmap(path, "<f4", "r", HEADER.itemsize, shape)


def flag():
    return {
        "name": "flag", "gravity": [0, -9.81, 0], "duration": 3, "wind": {"velocity": [6, 0, 2], "density": 1.2},
        "solver": {"type": "pbd", "dt": 1 / 60, "substeps": 10},
        "bodies": [{"name": "flag", "mass": 0.2, "pins": [{"particles": [21 * i for i in range(15)]}],
                    "transform": {"rotate": {"axis": [1, 0, 0], "degrees": 90}},
                    "constraints": [{"type": "distance", "elements": ["edges", "shear"]}, {"type": "bending", "rigidity": 1e-3}],
                    "shape": {"grid": {"size": [1.5, 1], "cells": [20, 14]}}}],
        "outputs": {"frames": {"every": 1, "formats": ["pc2"]}}}


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--out", default="frames.svg")
    arguments.add_argument("--run", default="out/frames_example", help="the folder of the run")
    given = arguments.parse_args()
    result = malha.run(flag(), given.run)
    frames = read_pc2(pathlib.Path(given.run) / "frames" / "points_flag.pc2")
    corner = frames[:, -1]  # the free one at the bottom
    print(result["summary"].splitlines()[0])
    print(f"{len(frames)} frames of {frames.shape[1]} vertices; the corner went {np.ptp(corner[:, 2]):.2f} m to and fro")
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    time = np.arange(len(frames)) / 60
    for axis, name in enumerate("xyz"):
        left.plot(time, corner[:, axis], label=name)
    left.set(xlabel="time (s)", ylabel="position (m)", title="The free corner of the flag")
    left.legend()
    for frame in range(0, len(frames), 12):
        edge = frames[frame].reshape(15, 21, 3)[7]  # the middle row, from the pole on
        right.plot(edge[:, 0], edge[:, 2], color=plt.cm.viridis(frame / len(frames)), linewidth=1)
    right.set(xlabel="x (m)", ylabel="z (m)", title="Its middle row seen from above, every 0.2 s", aspect="equal")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.savefig(given.out)


if __name__ == "__main__":
    main()
