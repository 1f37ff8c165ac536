#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes scenes/meshes/skirt.obj and scenes/meshes/cape.obj: garments for scenes/meshes/figure.glb.

usage: make_garments.py FOLDER [EDGE]

EDGE is the length of an edge in m (default 0.02). Both garments are cut from flat cloth: a sector of a ring, which the
texture coordinates hold in metres ("rest": {"uv": 1}). The skirt starts around the figure that stands, with a slit at
the back from the waist to the hem; its two sides are the first and the last vertex of each row, which a scene's "seams"
sew together. The cape starts as a cone that is open in front. Triangles are irregular: the diagonals alternate, and the
inner vertices are moved by up to a fifth of an edge, the same way in the pattern and around the figure.
"""

import os
import sys

import numpy as np


SLIT = 0.0005, 0.04  # m, its width at the waist and at the hem


def jitter(rows, columns, rng):
    """Offsets of the vertices in units of a cell, zero at the rims."""
    off = rng.uniform(-0.2, 0.2, (rows, columns, 2))
    off[0] = off[-1] = 0
    off[:, (0, -1)] = 0
    return off


def triangles(rows, columns, vertex):
    """Triangles of a grid of vertices, wound from rows to columns, with alternating diagonals."""
    all_ = []
    for r in range(rows - 1):
        for c in range(columns - 1):
            a, b, d, e = (r, c), (r, c + 1), (r + 1, c), (r + 1, c + 1)
            all_ += [(a, b, d), (b, e, d)] if (r + c) % 2 else [(a, e, d), (a, b, e)]
    return [tuple((vertex(*at), at) for at in t) for t in all_]


def write(path, name, points, texture, faces, columns):
    with open(path, "w", encoding="ascii") as out:
        out.write(f"# Made by tools/figure/make_garments.py\no {name}\n")
        for p in points:
            out.write("v %.7g %.7g %.7g\n" % tuple(p))
        for t in texture:
            out.write("vt %.7g %.7g\n" % tuple(t))
        for face in faces:
            out.write("f " + " ".join(f"{v + 1}/{r * columns + c + 1}" for v, (r, c) in face) + "\n")


def sector(inner, length, angle, rows, columns, off):
    """Points of a sector of a ring, as (rows, columns, 2), and the parameters (slope, angle) of each."""
    r, c = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    slope = length * (r + off[..., 0]) / (rows - 1)
    turn = angle * ((c + off[..., 1]) / (columns - 1) - 0.5)
    radius = inner + slope
    return np.stack([radius * np.sin(turn), -radius * np.cos(turn)], -1), slope, turn


def ellipse(a, b, count=4000):
    """Points of an ellipse at equal parts of its perimeter, from the back (-z) around by the left (+x)."""
    t = np.linspace(0, 2 * np.pi, count + 1)
    x, z = a * np.sin(t), -b * np.cos(t)
    s = np.concatenate([[0], np.cumsum(np.hypot(np.diff(x), np.diff(z)))])
    return s, x, z


def skirt(folder, edge, rng):
    waist, hem, length = 0.84, 1.76, 0.56  # m
    angle = (hem - waist) / length
    inner = waist / angle
    rows, columns = round(length / edge) + 1, round((waist + hem) / 2 / edge) + 1
    texture, slope, turn = sector(inner, length, angle, rows, columns, jitter(rows, columns, rng))
    points = []
    for r in range(rows):
        for c in range(columns):
            open_by = SLIT[0] + (SLIT[1] - SLIT[0]) * slope[r, c] / length
            around = (inner + slope[r, c]) * angle + open_by  # m, at this height; the ellipse has the same
            a = around * 0.185
            b = a  # found below
            low, high = 0.02, around
            for _ in range(50):
                b = (low + high) / 2
                low, high = (b, high) if ellipse(a, b, 400)[0][-1] < around else (low, b)
            s, x, z = ellipse(a, b)
            at = open_by / 2 + (turn[r, c] / angle + 0.5) * (s[-1] - open_by)
            # The slope of a cone: as far down as the pattern's length allows beside its widening.
            down = slope[r, c] * np.sqrt(1 - (angle / (2 * np.pi)) ** 2)
            points.append((np.interp(at, s, x), 1.075 - down, np.interp(at, s, z)))
    vertex = lambda r, c: r * columns + c
    write(os.path.join(folder, "skirt.obj"), "Skirt", points, texture.reshape(-1, 2),
          triangles(rows, columns, vertex), columns)
    return len(points)


def cape(folder, edge, rng):
    inner, length, angle, half = 0.09, 0.66, 1.35 * np.pi, np.radians(78)  # m; half the opening of the cone at the start
    rows = round(length / edge) + 1
    columns = round((inner + length / 2) * angle / edge) + 1
    texture, slope, turn = sector(inner, length, angle, rows, columns, jitter(rows, columns, rng))
    around = turn / np.sin(half)  # the cone's angle, 0 at the back
    radius = (inner + slope) * np.sin(half)
    points = np.stack([radius * np.sin(around), 1.55 - (inner + slope) * np.cos(half), -radius * np.cos(around)], -1)
    vertex = lambda r, c: r * columns + c
    write(os.path.join(folder, "cape.obj"), "Cape", points.reshape(-1, 3), texture.reshape(-1, 2),
          triangles(rows, columns, vertex), columns)
    return rows * columns


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    edge = float(sys.argv[2]) if len(sys.argv) == 3 else 0.02
    if not 0.002 <= edge <= 0.1:
        sys.exit(f"make_garments.py: EDGE {edge}; allowed: 0.002 to 0.1 m")
    rng = np.random.default_rng(49)
    for make in (skirt, cape):
        print(f"{make.__name__}.obj: {make(sys.argv[1], edge, rng)} vertices")


if __name__ == "__main__":
    main()
