#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes scenes/meshes/figure.glb: a figure of capsules that walks, for scenes with cloth on a body that moves.

usage: make_figure.py FILE.glb

The figure is 1.7 m high, stands at the origin, and faces +z. Its surface is one closed mesh: the zero level of the
smooth union of the capsules, by naive surface nets (Gibson 1998), whose vertices are then relaxed on it. Each vertex
follows up to four joints. Clips: "stand"; "walk", one cycle in place; "dress", half a second of standing, half a
second that leads into the walk, and ten seconds of walking. The script checks the mesh and the clips, and prints what
it found.
"""

import json
import struct
import sys

import numpy as np

PERIOD = 1.1  # s, of a cycle of the walk
KEYS_PER_SECOND = 30
BLEND = 0.03  # m, how far about a joint two capsules are blended
CELL = 0.026  # m, of the grid
OFFSET = np.array([0.0056, 0.0166, 0.0209])  # m, of the grid: one at which no cell is crossed twice

# Joints: name, parent, place at rest (m). Left is +x, since the figure faces +z. Arms are 30 degrees from the body.
ARM = np.array([np.sin(np.radians(30)), -np.cos(np.radians(30)), 0.0])
SHOULDER = np.array([0.19, 1.39, 0.0])
JOINTS = [
    ("pelvis", None, (0, 0.95, 0)),
    ("spine", "pelvis", (0, 1.04, 0)),
    ("chest", "spine", (0, 1.20, 0)),
    ("neck", "chest", (0, 1.42, 0)),
    ("head", "neck", (0, 1.52, 0)),
]
# Capsules: joint that they follow, ends (m), radii at the ends (m).
CAPSULES = [
    ("pelvis", (-0.06, 0.95, 0), (0.06, 0.95, 0), 0.11, 0.11),
    ("spine", (0, 1.02, 0), (0, 1.18, 0), 0.105, 0.10),
    ("chest", (-0.045, 1.28, 0), (0.045, 1.28, 0), 0.105, 0.105),
    ("chest", (-0.17, 1.39, 0), (0.17, 1.39, 0), 0.05, 0.05),
    ("neck", (0, 1.38, 0), (0, 1.50, 0.01), 0.052, 0.05),
    ("head", (0, 1.575, 0.01), (0, 1.61, 0.015), 0.085, 0.09),
]
for side, sign in (("left", 1), ("right", -1)):
    flip = np.array([sign, 1, 1])
    elbow, wrist, finger = (SHOULDER + length * ARM for length in (0.28, 0.53, 0.63))
    hip, knee, ankle = np.array([0.095, 0.90, 0]), np.array([0.105, 0.49, 0]), np.array([0.115, 0.08, -0.01])
    heel, toe = np.array([0.115, 0.045, -0.035]), np.array([0.12, 0.045, 0.13])
    JOINTS += [
        (f"upper_arm_{side}", "chest", flip * SHOULDER),
        (f"forearm_{side}", f"upper_arm_{side}", flip * elbow),
        (f"hand_{side}", f"forearm_{side}", flip * wrist),
        (f"thigh_{side}", "pelvis", flip * hip),
        (f"shin_{side}", f"thigh_{side}", flip * knee),
        (f"foot_{side}", f"shin_{side}", flip * ankle),
    ]
    CAPSULES += [
        (f"upper_arm_{side}", flip * SHOULDER, flip * elbow, 0.048, 0.042),
        (f"forearm_{side}", flip * elbow, flip * wrist, 0.042, 0.033),
        (f"hand_{side}", flip * wrist, flip * finger, 0.034, 0.036),
        (f"thigh_{side}", flip * hip, flip * knee, 0.075, 0.055),
        (f"shin_{side}", flip * knee, flip * ankle, 0.055, 0.04),
        (f"foot_{side}", flip * heel, flip * toe, 0.045, 0.045),
    ]
NAMES = [name for name, _, _ in JOINTS]
PARENTS = [NAMES.index(parent) if parent else -1 for _, parent, _ in JOINTS]
PLACES = np.array([np.asarray(place, float) for _, _, place in JOINTS])


# The surface.


def capsule_distance(x, a, b, radius_a, radius_b):
    """The distance of points from a capsule whose radius changes linearly, negative inside (nearly exact)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    share = np.clip(((x - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)[:, None]
    return np.linalg.norm(x - a - share * (b - a), axis=1) - (radius_a + share[:, 0] * (radius_b - radius_a))


def smooth_union(distances):
    """The minimum, blended where two are nearly equal (Quilez, polynomial)."""
    union = distances[0]
    for other in distances[1:]:
        h = np.maximum(BLEND - np.abs(union - other), 0) / BLEND
        union = np.minimum(union, other) - h * h * BLEND / 4
    return union


def distance(x):
    return smooth_union([capsule_distance(x, *capsule[1:]) for capsule in CAPSULES])


def gradient(x, step=1e-4):
    slope = np.empty_like(x)
    for k in range(3):
        e = np.zeros(3)
        e[k] = step
        slope[:, k] = (distance(x + e) - distance(x - e)) / (2 * step)
    return slope


def surface_nets():
    """Vertices and quads of the zero level: a vertex in each cell that it crosses, a quad about each such edge."""
    low, high = np.array([-0.62, -0.05, -0.2]) + OFFSET, np.array([0.62, 1.75, 0.25])
    counts = np.ceil((high - low) / CELL).astype(int) + 1
    axes = [low[k] + CELL * np.arange(counts[k]) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    level = distance(grid.reshape(-1, 3)).reshape(counts)

    sums, crossings = np.zeros((*(counts - 1), 3)), np.zeros(counts - 1, int)
    edges = []
    for k in range(3):
        start = level.take(range(counts[k] - 1), axis=k)
        end = level.take(range(1, counts[k]), axis=k)
        crossed = np.argwhere((start < 0) != (end < 0))
        at = tuple(crossed.T)
        place = grid[at].copy()
        place[:, k] += CELL * start[at] / (start[at] - end[at])
        i, j = (k + 1) % 3, (k + 2) % 3
        cells = []
        for back_i, back_j in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = crossed.copy()
            cell[:, i] -= back_i
            cell[:, j] -= back_j
            np.add.at(sums, tuple(cell.T), place)
            np.add.at(crossings, tuple(cell.T), 1)
            cells.append(cell)
        edges.append((cells, start[at] < 0))
    number = np.full(counts - 1, -1)
    number[crossings > 0] = np.arange((crossings > 0).sum())
    points = sums[crossings > 0] / crossings[crossings > 0][:, None]
    quads = []
    for cells, outwards in edges:
        around = np.stack([number[tuple(cell.T)] for cell in cells], axis=1)
        quads.append(np.where(outwards[:, None], around, around[:, ::-1]))
    return points, np.concatenate(quads)


def relax(points, quads, rounds=30):
    """Moves vertices towards the middle of their neighbours, and back onto the surface."""
    ends = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    for _ in range(rounds):
        sums, counts = np.zeros_like(points), np.zeros(len(points))
        np.add.at(sums, ends[:, 0], points[ends[:, 1]])
        np.add.at(counts, ends[:, 0], 1)
        points = points + 0.5 * (sums / counts[:, None] - points)
        for _ in range(2):
            slope = gradient(points)
            points = points - slope * (distance(points) / (slope * slope).sum(1))[:, None]
    return points


def triangles_of(points, quads):
    """Splits quads by their shorter diagonal."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    other = np.linalg.norm(a - c, axis=1) > np.linalg.norm(b - d, axis=1)
    first = np.where(other[:, None], quads[:, [0, 1, 3]], quads[:, [0, 1, 2]])
    second = np.where(other[:, None], quads[:, [1, 2, 3]], quads[:, [0, 2, 3]])
    return np.stack([first, second], axis=1).reshape(-1, 3)


def skin_weights(points, width=0.045):
    """Four joints a vertex, and their weights in 1/255: those of the capsules hardly farther than the nearest."""
    of_joints = np.full((len(points), len(NAMES)), np.inf)
    for joint, *capsule in CAPSULES:
        j = NAMES.index(joint)
        of_joints[:, j] = np.minimum(of_joints[:, j], capsule_distance(points, *capsule))
    farther = of_joints - of_joints.min(axis=1, keepdims=True)
    weights = np.maximum(1 - farther / width, 0) ** 2
    joints = np.argsort(-weights, axis=1)[:, :4]
    weights = np.take_along_axis(weights, joints, axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    whole = np.rint(255 * weights).astype(int)
    whole[:, 0] += 255 - whole.sum(axis=1)
    joints[whole == 0] = 0
    return joints.astype(np.uint8), whole.astype(np.uint8)


# The motion. An angle about +x takes what hangs down backwards; +z is ahead.


def rotation(axis, degrees):
    half = np.radians(degrees) / 2
    return np.array([*(np.sin(half) * np.asarray(axis, float)), np.cos(half)])


def product(p, q):
    v, w = np.cross(p[:3], q[:3]) + p[3] * q[:3] + q[3] * p[:3], p[3] * q[3] - p[:3] @ q[:3]
    return np.array([*v, w])


def bump(phase, middle, width):
    """A smooth hill in a cycle of 2 pi."""
    off = (phase - middle + np.pi) % (2 * np.pi) - np.pi
    return np.exp(-((off / width) ** 2))


def pose(phase, amount):
    """Rotations of all joints at a phase of the walk, and the sway of the pelvis (m). `amount` 0 is standing."""
    x, y, z = np.eye(3)
    turn = {name: np.array([0, 0, 0, 1.0]) for name in NAMES}
    turn["pelvis"] = product(rotation(y, -5 * amount * np.cos(phase)), rotation(z, 2.5 * amount * np.sin(phase)))
    turn["spine"] = product(rotation(y, 4 * amount * np.cos(phase)), rotation(z, -1.5 * amount * np.sin(phase)))
    turn["chest"] = product(rotation(x, 2 * amount), rotation(y, 6 * amount * np.cos(phase)))
    turn["neck"] = rotation(y, -5 * amount * np.cos(phase))
    for side, sign, of in (("left", 1, phase), ("right", -1, phase + np.pi)):
        # At a phase of 0 the leg is ahead and its heel touches the ground; then it moves back until a phase of pi.
        hip = 3 + 22 * np.cos(of)
        knee = 5 + 9 * bump(of, 0.3 * np.pi, 0.25 * np.pi) + 50 * bump(of, 1.42 * np.pi, 0.32 * np.pi)
        ankle = -4 * np.cos(of) - 14 * bump(of, 1.08 * np.pi, 0.22 * np.pi) + 6 * bump(of, 0.7 * np.pi, 0.3 * np.pi)
        turn[f"thigh_{side}"] = rotation(x, -amount * hip)
        turn[f"shin_{side}"] = rotation(x, amount * knee)
        turn[f"foot_{side}"] = rotation(x, -amount * ankle)
        swing = -20 * np.cos(of)
        turn[f"upper_arm_{side}"] = product(rotation(x, -amount * swing), rotation(z, -sign * 11))
        turn[f"forearm_{side}"] = rotation(x, -(8 + amount * (14 - 10 * np.cos(of))))
        turn[f"hand_{side}"] = rotation(x, -5)
    sway = 0.018 * amount * np.sin(phase)
    return np.array([turn[name] for name in NAMES]), sway


def matrix(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def joint_maps(turns, root):
    """Rotations and places of the joints."""
    maps = []
    for j, parent in enumerate(PARENTS):
        turn = matrix(turns[j])
        if parent < 0:
            maps.append((turn, root))
        else:
            above, place = maps[parent]
            maps.append((above @ turn, place + above @ (PLACES[j] - PLACES[parent])))
    return maps


def skinned(points, joints, weights, maps):
    moved = np.zeros_like(points)
    for k in range(4):
        turns = np.array([turn for turn, _ in maps])[joints[:, k]]
        places = np.array([place for _, place in maps])[joints[:, k]]
        of = np.einsum("nij,nj->ni", turns, points - PLACES[joints[:, k]]) + places
        moved += (weights[:, k] / 255.0)[:, None] * of
    return moved


class Clip:
    """Keys of a clip: the phase of the walk and its amount at each time."""

    def __init__(self, name, times, phases, amounts, mesh, is_loop):
        self.name, self.times = name, times
        poses = [pose(phase, amount) for phase, amount in zip(phases, amounts)]
        self.turns = np.array([turns for turns, _ in poses])
        self.roots = np.tile(PLACES[0], (len(times), 1))
        self.roots[:, 0] += [sway for _, sway in poses]
        # The pelvis is as high as the lower foot on the ground needs, smoothed over some keys.
        lowest = np.array([self.points(i, mesh)[:, 1].min() for i in range(len(times))])
        if is_loop:
            lowest = np.concatenate([lowest[:-1], lowest[:-1], lowest])
        padded = np.concatenate([[lowest[0]] * 3, lowest, [lowest[-1]] * 3])
        weights = np.array([1, 3, 6, 7, 6, 3, 1]) / 27
        smooth = np.convolve(padded, weights, mode="valid")
        if is_loop:
            smooth = smooth[len(times) - 1 :][: len(times)]
            smooth[-1] = smooth[0]
        self.roots[:, 1] -= smooth

    def points(self, i, mesh):
        points, joints, weights = mesh
        return skinned(points, joints, weights, joint_maps(self.turns[i], self.roots[i]))


def make_clips(mesh):
    cycle = np.arange(int(PERIOD * KEYS_PER_SECOND) + 1) / KEYS_PER_SECOND
    phase = 2 * np.pi / PERIOD
    long = np.arange(11 * KEYS_PER_SECOND + 1) / KEYS_PER_SECOND
    share = np.clip((long - 0.5) / 0.5, 0, 1)
    amounts = share * share * (3 - 2 * share)
    start = 0.5 * np.pi  # where the legs are beside each other
    return [
        Clip("stand", np.array([0.0]), [0.0], [0.0], mesh, False),
        Clip("walk", cycle, phase * cycle, np.ones(len(cycle)), mesh, True),
        Clip("dress", long, start + phase * (long - 0.5), amounts, mesh, False),
    ]


# Checks.


def crossings(points, triangles):
    """The number of edges that go through triangles with which they share no vertex."""
    ends = np.unique(np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1), axis=0)
    corners = points[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found = 0
    for a, b in ends:
        p, q = points[a], points[b]
        near = np.nonzero(((low <= np.maximum(p, q)) & (high >= np.minimum(p, q))).all(axis=1))[0]
        near = near[~((triangles[near] == a) | (triangles[near] == b)).any(axis=1)]
        if len(near) == 0:
            continue
        from_p, from_q = (((x - corners[near, 0]) * normal[near]).sum(1) for x in (p, q))
        through = np.nonzero(from_p * from_q < 0)[0]
        for t in near[through]:
            x, y, z = corners[t]
            sides = [np.dot(np.cross(u - p, v - p), q - p) for u, v in ((x, y), (y, z), (z, x))]
            found += min(sides) > 0 or max(sides) < 0
    return found


def check_closed(points, triangles):
    """Every edge has two triangles, in opposite directions; every vertex one fan of them; the volume is positive."""
    directed = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    forwards = {tuple(edge) for edge in directed}
    assert len(forwards) == len(directed), "an edge of two triangles in one direction"
    assert all((b, a) in forwards for a, b in forwards), "an open edge"
    following = {(t[k], t[(k + 1) % 3]): t[(k + 2) % 3] for t in triangles for k in range(3)}
    fans = {}
    for a, b in forwards:
        fans.setdefault(a, []).append(b)
    for a, around in fans.items():
        b, steps = around[0], 0
        while True:
            b, steps = following[a, b], steps + 1
            if b == around[0]:
                break
        assert steps == len(around), f"vertex {a} has two fans"
    corners = points[triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume > 0, "triangles face inwards"
    assert len(points) - len(directed) // 2 + len(triangles) == 2, "a surface that is no sphere"
    return volume


def gaps(points, joints):
    """The smallest distances of the arms from the trunk and the legs, and of the legs from each other (m)."""
    main = [NAMES[j] for j in joints[:, 0]]
    group = lambda *parts: points[[any(name.startswith(part) for part in parts) for name in main]]
    least = lambda a, b: np.sqrt(min(((a - x) ** 2).sum(1).min() for x in b))
    arms = group("forearm", "hand")
    legs = [group(f"{part}_{side}") for side in ("left", "right") for part in ("shin", "foot")]
    return (least(arms, group("pelvis", "spine", "thigh")),
            min(least(legs[i], legs[j]) for i in (0, 1) for j in (2, 3)))


# The file.


def write_glb(path, points, triangles, joints, weights, clips):
    data, views, accessors = bytearray(), [], []

    def add(array, kind, **more):
        data.extend(b"\0" * (-len(data) % 4))
        array = np.ascontiguousarray(array)
        component = {"float32": 5126, "uint16": 5123, "uint8": 5121}[array.dtype.name]
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind, **more}
        )
        data.extend(array.tobytes())
        return len(accessors) - 1

    single = points.astype(np.float32)
    corners = points[triangles]
    normals, faces = np.zeros_like(points), np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        np.add.at(normals, triangles[:, k], faces)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    bind = np.tile(np.eye(4, dtype=np.float32), (len(NAMES), 1, 1))
    bind[:, 3, :3] = -PLACES  # by columns
    primitive = {
        "attributes": {
            "POSITION": add(single, "VEC3", min=single.min(0).tolist(), max=single.max(0).tolist()),
            "NORMAL": add(normals.astype(np.float32), "VEC3"),
            "JOINTS_0": add(joints, "VEC4"),
            "WEIGHTS_0": add(weights, "VEC4", normalized=True),
        },
        "indices": add(triangles.astype(np.uint16).reshape(-1), "SCALAR"),
    }
    nodes = []
    for j, name in enumerate(NAMES):
        offset = PLACES[j] - (PLACES[PARENTS[j]] if PARENTS[j] >= 0 else 0)
        children = [i for i, parent in enumerate(PARENTS) if parent == j]
        nodes.append({"name": name, "translation": offset.tolist(), **({"children": children} if children else {})})
    nodes.append({"name": "figure", "mesh": 0, "skin": 0})
    animations = []
    for clip in clips:
        times = clip.times.astype(np.float32)
        keys = add(times, "SCALAR", min=[float(times.min())], max=[float(times.max())])
        animation = {"name": clip.name, "samplers": [], "channels": []}

        def channel(node, path, values, kind):
            output = add(values.astype(np.float32), kind)
            animation["samplers"].append({"input": keys, "output": output, "interpolation": "LINEAR"})
            of = len(animation["samplers"]) - 1
            animation["channels"].append({"sampler": of, "target": {"node": node, "path": path}})

        channel(0, "translation", clip.roots, "VEC3")
        for j in range(len(NAMES)):
            if np.abs(clip.turns[:, j] - [0, 0, 0, 1]).max() > 0:
                channel(j, "rotation", clip.turns[:, j], "VEC4")
        animations.append(animation)
    document = {
        "asset": {"version": "2.0", "generator": "malha, tools/figure/make_figure.py"},
        "scene": 0,
        "scenes": [{"nodes": [0, len(NAMES)]}],
        "nodes": nodes,
        "meshes": [{"name": "figure", "primitives": [primitive]}],
        "skins": [{"inverseBindMatrices": add(bind.reshape(-1, 16), "MAT4"), "joints": list(range(len(NAMES)))}],
        "animations": animations,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data.extend(b"\0" * (-len(data) % 4))
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)
    return 28 + len(text) + len(data)


def main(path):
    points, quads = surface_nets()
    points = relax(points, quads)
    triangles = triangles_of(points, quads)
    volume = check_closed(points, triangles)
    joints, weights = skin_weights(points)
    mesh = (points, joints, weights)
    edges = np.linalg.norm(points[triangles] - points[np.roll(triangles, 1, axis=1)], axis=2)
    print(
        f"{len(points)} vertices, {len(triangles)} triangles, {1000 * volume:.1f} litres, "
        f"{points[:, 1].max():.3f} m high, edges {1000 * edges.min():.1f} to {1000 * edges.max():.1f} mm; "
        f"{crossings(points, triangles)} crossings at rest"
    )
    clips = make_clips(mesh)
    walk = clips[1]
    for clip in clips:
        keys = range(0, len(clip.times), max(1, len(clip.times) // 12)) if clip.name != "dress" else (0, 20, 25)
        poses = [clip.points(i, mesh) for i in keys]
        arm, leg = np.min([gaps(x, joints) for x in poses], axis=0)
        ground = [1000 * x[:, 1].min() for x in poses]
        print(
            f"{clip.name}: {clip.times[-1]:.2f} s, soles at {min(ground):.1f} to {max(ground):.1f} mm, forearms "
            f"{100 * arm:.1f} cm from trunk and thighs, legs {100 * leg:.1f} cm from each other, "
            f"{max(crossings(x, triangles) for x in poses)} crossings"
        )
    reach = [joint_maps(walk.turns[i], walk.roots[i])[NAMES.index("foot_left")][1][2] for i in range(len(walk.times))]
    stride = 2 * (max(reach) - min(reach))
    print(f"a cycle of the walk would lead {stride:.2f} m ahead: {stride / PERIOD:.2f} m/s")
    print(f"{path}: {write_glb(path, points, triangles, joints, weights, clips)} bytes")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
