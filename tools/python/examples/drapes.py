# SPDX-License-Identifier: Apache-2.0
"""A data set for learning: many garments, each draped on a figure, as one HDF5 file and a page of thumbnails.

Each garment is a skirt that is cut from a sector of a ring: its length, its fullness and its cloth differ, and so
does the figure on which it falls. malha.sweep makes the drapes, on the cores of this machine or on a Dask cluster, and makes
none twice: what was killed is called again.

The file holds, for D drapes of V vertices in F frames:
  positions    float32 (D, F, V, 3), m: the garments in time
  rest         float32 (D, V, 3), m: their first frame, in which they are unstrained
  faces        int32 (T, 4): the same for all
  body         float32 (D, 3, 7), m: two ends and the radius of the three capsules of each figure
  parameters/  one number a drape for each parameter
  state_hash   16 digits a drape: equal drapes have equal ones, on any machine
"""
import argparse
import concurrent.futures
import html
import multiprocessing
import os
import pathlib

import h5py
import numpy as np

import malha
from frames import read_pc2

ROUND, DOWN = 48, 12  # cells of a garment
WAIST, HEIGHT = 0.13, 1.0  # m, of the ring that is held
# Each parameter of a drape, with its range: that of cloth as `malha materials` lists it, and of figures.
RANGES = {"length": (0.35, 0.6), "fullness": (0.6, 1), "density": (0.11, 0.33), "rigidity": (3e-6, 3e-5),
          "hips": (0.14, 0.17), "stance": (0, 0.06)}


def pattern(length, fullness):
    """Vertices (V, 3), m, and faces (T, 4) of a skirt: a cone, which is the sector of a ring rolled up, without strain.

    length: from waist to hem, m. fullness: the sector's part of a whole ring, which lies flat.
    """
    turn = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    slant = np.linspace(0, length, DOWN + 1)
    radius, y = WAIST + slant * fullness, HEIGHT - slant * np.sqrt(1 - fullness**2)
    points = np.stack([radius[:, None] * np.cos(turn), np.repeat(y[:, None], ROUND, axis=1), radius[:, None] * np.sin(turn)],
                      axis=2).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(DOWN), np.arange(ROUND), indexing="ij")
    here, right = row * ROUND + column, row * ROUND + (column + 1) % ROUND
    return points, np.stack([here, right, right + ROUND, here + ROUND], axis=2).reshape(-1, 4)


def figure(hips, stance):
    """Capsules (3, 7), m: two ends and a radius, of the hips and of two legs that stand apart."""
    side = hips - 0.075
    legs = [[x * side, HEIGHT - 0.2, 0, x * (side + stance), 0.1, 0, 0.075] for x in (-1, 1)]
    return np.array([[-side, HEIGHT - 0.15, 0, side, HEIGHT - 0.15, 0, 0.09], *legs])


def garment(length, fullness, density, rigidity, hips, stance):
    """The scene of a drape. density: kg/m^2; rigidity: of its bending, N m. The cloth hardly stretches."""
    points, faces = pattern(length, fullness)
    skirt = malha.body(points, faces, name="skirt", density=density, damping=0.5, pins=range(ROUND),
                       constraints=[{"type": "distance", "elements": ["edges", "shear"]},
                                    {"type": "bending", "rigidity": rigidity}])
    body = [{"name": f"body {number}", "thickness": 0.004, "friction": 0.4,
             "shape": {"capsule": {"from": list(one[:3]), "to": list(one[3:6]), "radius": one[6]}}}
            for number, one in enumerate(figure(hips, stance))]
    return {"name": "a drape", "gravity": [0, -9.81, 0], "duration": 1.5, "bodies": [skirt], "environment": body,
            "solver": {"type": "pbd", "dt": 1 / 30, "substeps": 30, "precision": "float"},
            "self_collision": {"thickness": 0.004, "friction": 0.3},
            "outputs": {"frames": {"every": 1, "formats": ["pc2"]},
                        "pictures": {"size": [240, 240], "camera": {"eye": [0.9, 1.1, 1.6], "target": [0, 0.66, 0],
                                                                     "fov_degrees": 30}}},
            "expect": {"max_penetration": 0, "max_crossings": 0}}


def drawn(count, seed=0):
    """The parameters of each drape."""
    random = np.random.default_rng(seed)
    return [{name: float(random.uniform(*between)) for name, between in RANGES.items()} for _ in range(count)]


def store(table, path):
    """Writes the file of the data set, completely or not at all."""
    runs = [pathlib.Path(one) for one in table["path"]]
    first = read_pc2(runs[0] / "frames" / "points_skirt.pc2")
    part = path.with_suffix(".part")
    with h5py.File(part, "w") as file:
        file.attrs["description"], file.attrs["malha"] = __doc__, malha.__version__
        positions = file.create_dataset("positions", (len(runs), *first.shape), "f4", chunks=(1, *first.shape), compression="gzip",
                                        shuffle=True)
        for number, run in enumerate(runs):
            positions[number] = read_pc2(run / "frames" / "points_skirt.pc2")
        file["rest"] = positions[:, 0]
        file["faces"] = pattern(1, 1)[1].astype("i4")
        file["body"] = np.array([figure(*pair) for pair in zip(table["hips"], table["stance"])], "f4")
        for name in RANGES:
            file[f"parameters/{name}"] = np.array(table[name], "f8")
        file["state_hash"] = np.array(list(table["state_hash"]), "S16")
    os.replace(part, path)


def page(table, path):
    """Writes a page with a thumbnail of each drape and its parameters."""
    cells = "".join(
        f'<figure><img loading="lazy" width="160" height="160" src="{html.escape(os.path.relpath(row["path"], path.parent))}'
        f'/picture.png" alt="drape {number}"><figcaption>{number}: {row["length"]:.2f} m, fullness {row["fullness"]:.2f}, '
        f'{row["density"]:.2f} kg/m2, {row["rigidity"]:.1e} N m</figcaption></figure>' for number, row in table.iterrows())
    path.write_text('<!doctype html><meta charset="utf-8"><title>Drapes</title><style>body{font:13px sans-serif;display:flex;'
                    'flex-wrap:wrap;gap:8px}figure{margin:0;width:160px}</style>' + cells + "\n")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--count", type=int, default=12, help="how many drapes; 1000 for learning")
    arguments.add_argument("--seed", type=int, default=0, help="of the parameters")
    arguments.add_argument("--workers", type=int, default=os.cpu_count(), help="processes on this machine")
    arguments.add_argument("--dask", help="address of a Dask scheduler, whose workers are taken instead")
    arguments.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/drapes"), help="the folder of the data set")
    given = arguments.parse_args()

    def show(done, runs):
        print(f"\r{done} of {runs} drapes", end="", flush=True)

    if given.dask:
        from distributed import Client
        with Client(given.dask) as client:
            client.upload_file(str(pathlib.Path(__file__).with_name("frames.py")))
            client.upload_file(__file__)
            from drapes import garment as named  # by a name that the workers know
            table = malha.sweep(named, drawn(given.count, given.seed), client, out=given.out / "runs", progress=show)
    else:
        spawn = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(given.workers, mp_context=spawn) as pool:
            table = malha.sweep(garment, drawn(given.count, given.seed), pool, out=given.out / "runs", progress=show)
    whole = table[table["status"] == "finished"].reset_index(drop=True)
    store(whole, given.out / "drapes.h5")
    page(whole, given.out / "index.html")
    unmet = (whole["notes"] != "").sum()
    print(f"\n{len(whole)} of {len(table)} drapes in {given.out / 'drapes.h5'} and on {given.out / 'index.html'}; "
          f"{unmet} with notes; strain up to {whole['strain_max'].max():.2f}")


if __name__ == "__main__":
    main()
