# SPDX-License-Identifier: Apache-2.0
"""Blender and back: exports objects for malha, and plays the frames of a run on the same objects.

  blender -b garment.blend -P blender.py -- export garment.obj [--objects Cape Hood]
  malha run scene.json --format pc2 --out out/garment
  blender -b garment.blend -P blender.py -- apply out/garment/frames [--rate 60] [--save FILE] [--render FILE --frame N]

Objects keep their vertices, texture coordinates, materials and other modifiers: each gets a modifier Mesh Cache, first
of its modifiers, that reads its file points_NAME.pc2. Its transform is set to the identity, because malha's places are
those of the world.
"""
import argparse
import math
import pathlib
import struct
import sys

import bpy
from mathutils import Vector

MODIFIER = "malha"


def stem(name):
    """The name as malha writes it into names of files."""
    name = "_" + name if not name or name[0] == "." else name
    return "".join("_" if ord(letter) < 32 or letter in '/\\:*?"<>|' else letter for letter in name)


def meshes(names):
    found = [one for one in bpy.context.scene.objects if one.type == "MESH" and (not names or one.name in names)]
    missing = set(names or ()) - {one.name for one in found}
    if missing:
        sys.exit(f"no mesh {', '.join(sorted(missing))}; there are: {', '.join(one.name for one in meshes(None))}")
    return found


def export(given):
    for one in bpy.context.scene.objects:
        one.select_set(False)
    for one in meshes(given.objects):
        one.select_set(True)
    # Y is up in malha; modifiers would change the vertices, and triangles the polygons.
    bpy.ops.wm.obj_export(filepath=str(pathlib.Path(given.file).absolute()), export_selected_objects=True,
                          apply_modifiers=False, export_triangulated_mesh=False, export_normals=False, export_uv=True,
                          export_materials=True, path_mode="RELATIVE")


def header(path):
    """Number of points, first frame and number of frames of a point cache."""
    with open(path, "rb") as file:
        signature, _, points, first, _, frames = struct.unpack("<12siiffi", file.read(32))
    if signature != b"POINTCACHE2\0":
        sys.exit(f"{path}: found {signature!r}; allowed: a PointCache2 file")
    return points, first, frames


def put_first(one, modifier):
    with bpy.context.temp_override(object=one):
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def apply(given):
    folder = pathlib.Path(given.frames).absolute()
    found = 0
    for one in meshes(None):
        # Blender's exporter writes a blank in a name as _.
        paths = [folder / f"points_{stem(name)}.pc2" for name in (one.name, one.name.replace(" ", "_"))]
        path = next((path for path in paths if path.exists()), None)
        if not path:
            continue
        points, first, frames = header(path)
        if points != len(one.data.vertices):
            sys.exit(f"{path}: {points} points; the mesh of {one.name} has {len(one.data.vertices)} vertices")
        old = one.modifiers.get(MODIFIER)
        if old:
            one.modifiers.remove(old)
        cache = one.modifiers.new(MODIFIER, "MESH_CACHE")
        cache.cache_format, cache.filepath = "PC2", str(path)
        cache.forward_axis, cache.up_axis = "POS_Z", "NEG_Y"  # where Y and Z of Blender are in the file
        cache.time_mode, cache.play_mode, cache.frame_start, cache.interpolation = "FRAME", "SCENE", first, "LINEAR"
        put_first(one, cache)
        one.matrix_world.identity()
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 0, max(int(first) + frames - 1, 0)
        found += 1
        print(f"{one.name}: {frames} frames of {points} vertices from {path.name}")
    if not found:
        sys.exit(f"{folder}: no points_NAME.pc2 of an object of this file")
    bpy.context.scene.render.fps = given.rate
    if given.save:
        bpy.ops.wm.save_as_mainfile(filepath=str(pathlib.Path(given.save).absolute()))
    if given.render:
        render(given)


def render(given):
    scene = bpy.context.scene
    scene.frame_set(given.frame)
    if not scene.camera:
        graph = bpy.context.evaluated_depsgraph_get()
        corners = [seen.matrix_world @ Vector(corner) for seen in (one.evaluated_get(graph) for one in meshes(None))
                   for corner in seen.bound_box]
        middle = sum(corners, Vector()) / len(corners)
        away = max((corner - middle).length for corner in corners) / math.sin(0.3)
        eye = middle + away * Vector((0.5, -1, 0.35)).normalized()
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(scene.camera)
        scene.camera.data.angle, scene.camera.location = 0.7, eye
        scene.camera.rotation_euler = (middle - eye).to_track_quat("-Z", "Y").to_euler()
    if not any(one.type == "LIGHT" for one in scene.objects):
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.data.energy, sun.rotation_euler = 3, (0.7, 0.2, 0.5)
        scene.collection.objects.link(sun)
    if not scene.world:
        scene.world = bpy.data.worlds.new("world")
        scene.world.color = (0.4, 0.4, 0.4)
    # Cycles renders without a screen. Debian's is built without a denoiser.
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y = given.size
    scene.render.filepath = str(pathlib.Path(given.render).absolute())
    bpy.ops.render.render(write_still=True)


def main():
    parser = argparse.ArgumentParser(prog="blender -b FILE -P blender.py --", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    out = commands.add_parser("export", help="writes objects as OBJ with their names, texture coordinates, materials")
    out.add_argument("file")
    out.add_argument("--objects", nargs="+", help="names of objects; all meshes if none are given")
    back = commands.add_parser("apply", help="plays the frames of a run on the objects")
    back.add_argument("frames", help="the folder of points_NAME.pc2")
    back.add_argument("--rate", type=int, default=60, help="frames of the run in a second: 1 / (every * dt)")
    back.add_argument("--save", help="a .blend file")
    back.add_argument("--render", help="a picture of one frame, by Cycles")
    back.add_argument("--frame", type=int, default=0)
    back.add_argument("--size", type=int, nargs=2, default=(960, 540))
    given = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    {"export": export, "apply": apply}[given.command](given)


if __name__ == "__main__":
    main()
