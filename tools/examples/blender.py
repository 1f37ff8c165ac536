# SPDX-License-Identifier: Apache-2.0
"""Blender and back: exports objects for malha, and plays the frames of a run on the same objects.

  blender -b garment.blend -P blender.py -- export garment.obj [--objects Cape Hood]
  malha run scene.json --format pc2 --out out/garment
  blender -b garment.blend -P blender.py -- apply out/garment/frames [--save FILE] [--render FILE --frame N]

Objects keep their vertices, texture coordinates, materials and other modifiers: each gets a modifier Mesh Cache, first
of its modifiers, that reads its file points_NAME.pc2. Its transform is set to the identity, because malha's places are
those of the world.
"""
import argparse
import json
import math
import pathlib
import struct
import sys

import bpy
from mathutils import Vector

MODIFIER = "malha"


def meshes(names):
    """The visible meshes, or those of these names."""
    there = {one.name: one for one in bpy.context.scene.objects if one.type == "MESH"}
    missing = [name for name in names or () if name not in there]
    if missing:
        sys.exit(f"found no mesh {', '.join(missing)}; allowed: {', '.join(sorted(there))}")
    return [one for one in there.values() if (one.name in names if names else one.visible_get())]


def exported(name):
    """The name of an object as Blender's exporter writes it."""
    return name.replace(" ", "_")


def export(given):
    for one in bpy.context.scene.objects:
        one.select_set(False)
    chosen = meshes(given.objects)
    names = [exported(one.name) for one in chosen]
    for one in chosen:
        if names.count(exported(one.name)) > 1:
            sys.exit(f"found several objects that the file would call {exported(one.name)}; allowed: names that differ")
        one.hide_set(False)
        one.hide_viewport = False
        one.select_set(True)
        if not one.select_get():
            sys.exit(f"found {one.name} in a collection that is hidden; allowed: objects that can be selected")
    if not chosen:
        sys.exit("found no visible mesh; allowed: one or more, or names by --objects")
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


def caches(folder):
    """The point cache of each mesh of a run, by the mesh's name: rest.obj has the names, in the order of the files."""
    rest = folder / "rest.obj"
    if not rest.exists():
        sys.exit(f"{folder}: found no rest.obj; allowed: the frames of a run with --format pc2")
    found, taken = {}, set()
    for line in rest.read_text(errors="surrogateescape").splitlines():
        if not line.startswith("o "):
            continue
        name = line[2:]
        stem = "_" + name if name[0] == "." else name
        stem = "".join("_" if ord(letter) < 32 or letter in '/\\:*?"<>|' else letter for letter in stem)
        while stem in taken:
            stem += "_"
        taken.add(stem)
        found[name] = folder / f"points_{stem}.pc2"
    return found


def rate_of(folder):
    """Frames in a second, by the report of the run beside the frames."""
    report = folder.parent / "report.json"
    try:
        scene = json.loads(report.read_text())["input"]["scene"]
        return 1 / (scene["solver"]["dt"] * scene["outputs"]["frames"]["every"])
    except (OSError, ValueError, KeyError, ZeroDivisionError):
        sys.exit(f"{report}: found no scene with frames; allowed: --rate")


def put_first(one, modifier):
    with bpy.context.temp_override(object=one):
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def moves(one):
    """True if keyframes or drivers move the object or what it hangs on, which a transform of its own cannot undo."""
    while one:
        if one.animation_data and (one.animation_data.action or one.animation_data.drivers):
            return True
        one = one.parent
    return False


def apply(given):
    folder = pathlib.Path(given.frames).absolute()
    there = caches(folder)
    chosen = [(one, there.get(one.name) or there.get(exported(one.name))) for one in meshes(given.objects)
              if given.objects or one.name in there or exported(one.name) in there]
    if not chosen or not all(path for _, path in chosen):
        sys.exit(f"{folder}: found caches of {', '.join(there)}; allowed: those of the objects here, "
                 + ", ".join(one.name for one in meshes(given.objects)))
    by_path = {}
    for one, path in chosen:
        if by_path.setdefault(path, one) is not one:
            sys.exit(f"{path}: found the objects {by_path[path].name} and {one.name}; allowed: one, by --objects")
        points, _, _ = header(path)
        if points != len(one.data.vertices):
            sys.exit(f"{path}: found {points} points; allowed: {len(one.data.vertices)}, the vertices of {one.name}")
        if moves(one):
            sys.exit(f"{one.name}: found a transform that is animated; allowed: none, because places are of the world")
    rate = given.rate or rate_of(folder)
    scene = bpy.context.scene
    for one, path in chosen:
        points, first, frames = header(path)
        old = one.modifiers.get(MODIFIER)
        if old:
            one.modifiers.remove(old)
        cache = one.modifiers.new(MODIFIER, "MESH_CACHE")
        cache.cache_format, cache.filepath = "PC2", str(path)
        cache.forward_axis, cache.up_axis = "POS_Z", "NEG_Y"  # where Y and Z of Blender are in the file
        cache.time_mode, cache.play_mode, cache.frame_start, cache.interpolation = "FRAME", "SCENE", first, "LINEAR"
        put_first(one, cache)
        one.matrix_world.identity()
        scene.frame_start, scene.frame_end = 0, max(int(first) + frames - 1, 0)
        print(f"{one.name}: {frames} frames of {points} vertices from {path.name}")
    scene.render.fps = max(round(rate), 1)
    scene.render.fps_base = scene.render.fps / rate
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
    out.add_argument("--objects", nargs="+", help="names of objects; all visible meshes if none are given")
    back = commands.add_parser("apply", help="plays the frames of a run on the objects")
    back.add_argument("frames", help="the folder of points_NAME.pc2")
    back.add_argument("--objects", nargs="+", help="names of objects; all that the run has if none are given")
    back.add_argument("--rate", type=float, help="frames in a second; by default those of ../report.json")
    back.add_argument("--save", help="a .blend file")
    back.add_argument("--render", help="a picture of one frame, by Cycles")
    back.add_argument("--frame", type=int, default=0)
    back.add_argument("--size", type=int, nargs=2, default=(960, 540))
    given = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    {"export": export, "apply": apply}[given.command](given)


if __name__ == "__main__":
    main()
