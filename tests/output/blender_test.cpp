// SPDX-License-Identifier: Apache-2.0
// A garment that is made in Blender goes through malha and back onto the same objects, by tools/examples/blender.py, as
// scenes/blender.md says.
#include <gtest/gtest.h>

#include <cmath>

#include "host/mesh/io/mesh_io.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Makes two objects that are moved and turned: one with a hexagon, quads and triangles in two materials, a seam in its
/// texture coordinates, a vertex that nothing uses and a modifier, and one of triangles.
constexpr char kMake[] = R"PY(
import bpy, random, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
random.seed(3)
def add(name, verts, faces, seam, materials, at, turned):
    mesh = bpy.data.meshes.new(name + ' mesh')
    mesh.from_pydata(verts, [], faces)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    for material in materials:
        mesh.materials.append(bpy.data.materials.get(material) or bpy.data.materials.new(material))
    layer = mesh.uv_layers.new(name='pattern')
    for polygon in mesh.polygons:
        polygon.material_index = polygon.index % len(materials)
        for corner in polygon.loop_indices:
            x = verts[mesh.loops[corner].vertex_index]
            layer.data[corner].uv = (x[0] + (2 if seam and polygon.center[0] > 0.5 else 0), x[1])
    thing.location, thing.rotation_euler = at, turned
    return thing
n = 6
verts = [(0.2 * i + random.uniform(0, 0.05), 0.2 * j + random.uniform(0, 0.05), random.uniform(0, 0.05))
         for j in range(n + 1) for i in range(n + 1)] + [(0.7, 0.7, 0.5)]
faces = []
for j in range(n):
    for i in range(n):
        a, b = j * (n + 1) + i, (j + 1) * (n + 1) + i
        if (i, j) == (2, 2): faces.append([a, a + 1, a + 2, b + 2, b + 1, b])
        elif (i, j) == (3, 2): continue
        elif (i + j) % 3 == 0: faces += [[a, a + 1, b + 1], [a, b + 1, b]]
        else: faces.append([a, a + 1, b + 1, b])
cape = add('Cape of wool', verts, faces, True, ['Wool', 'Lining'], (0.3, -0.2, 2), (0.3, 0.1, 0.7))
cape.modifiers.new('fine', 'SUBSURF')
add('Hood', [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.2)], [[0, 1, 2], [2, 1, 3]], False, ['Wool'], (0, 0, 3), (0, 0, 0))
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
)PY";

/// Writes what the objects of two files are, and where their vertices are at each frame of the second.
constexpr char kLook[] = R"PY(
import bpy, json, sys
before, after, out, frames = sys.argv[sys.argv.index('--') + 1:]
def state():
    return {thing.name: {
        'vertices': [list(v.co) for v in thing.data.vertices],
        'polygons': [[list(p.vertices), p.material_index] for p in thing.data.polygons],
        'materials': [material.name for material in thing.data.materials],
        'texture': [[list(corner.uv) for corner in layer.data] for layer in thing.data.uv_layers],
        'modifiers': [[modifier.name, modifier.type] for modifier in thing.modifiers]}
        for thing in bpy.data.objects if thing.type == 'MESH'}
bpy.ops.wm.open_mainfile(filepath=before)
found = {'before': state(), 'frames': []}
bpy.ops.wm.open_mainfile(filepath=after)
found['after'] = state()
for thing in bpy.data.objects:
    for modifier in thing.modifiers:
        modifier.show_viewport = modifier.type == 'MESH_CACHE'
for frame in range(int(frames)):
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    places = []
    for name in ('Cape of wool', 'Hood'):
        seen = bpy.data.objects[name].evaluated_get(graph)
        mesh = seen.to_mesh()
        places += [list(seen.matrix_world @ v.co) for v in mesh.vertices]
        seen.to_mesh_clear()
    found['frames'].append(places)
with open(out, 'w') as file:
    json.dump(found, file)
)PY";

/// Imports rest.obj, and writes the objects' polygons and texture coordinates, and where their vertices are at the last
/// frame of the caches.
constexpr char kImport[] = R"PY(
import bpy, json, sys
frames, out, last = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=frames + '/rest.obj')
bpy.context.scene.frame_set(int(last))
found = {}
for thing in bpy.data.objects:
    cache = thing.modifiers.new('cache', 'MESH_CACHE')
    cache.cache_format, cache.filepath = 'PC2', frames + '/points_' + thing.name + '.pc2'
    cache.time_mode, cache.play_mode, cache.frame_start = 'FRAME', 'SCENE', 0
    seen = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    found[thing.name] = {'places': [list(seen.matrix_world @ v.co) for v in mesh.vertices],
                         'polygons': [len(p.vertices) for p in mesh.polygons],
                         'materials': [material.name for material in thing.data.materials],
                         'texture': [list(corner.uv) for corner in mesh.uv_layers[0].data]}
    seen.to_mesh_clear()
with open(out, 'w') as file:
    json.dump(found, file)
)PY";

class Blender : public testing::Test {
 protected:
  void SetUp() override {
    if (blender_.empty()) GTEST_SKIP() << "no blender: tools/setup blender";
  }

  /// Runs Blender on a file ("": none) with this script and arguments.
  void blend(const std::string& file, const std::string& script, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{"--background", "--factory-startup", "--python-exit-code", "1"};
    if (!file.empty()) words.insert(words.begin() + 2, file);
    words.insert(words.end(), {"--python", script, "--"});
    words.insert(words.end(), arguments.begin(), arguments.end());
    const Ended ended = MalhaProcess(words, folder_ / "", RLIM_INFINITY, blender_).wait();
    ASSERT_EQ(ended.status, 0) << ended.out << ended.err;
  }

  /// Makes the garment, exports it, and simulates 13 frames of it.
  void simulate() {
    blend("", folder_.write("make.py", kMake), {folder_ / "garment.blend"});
    blend(folder_ / "garment.blend", kScript, {"export", folder_ / "garment.obj"});
    Json scene = swinging_sheet(false, "double");
    scene["bodies"][0]["name"] = "garment", scene["bodies"][0]["shape"] = {{"mesh", folder_ / "garment.obj"}};
    scene["bodies"][0].erase("transform");
    scene["bodies"][0]["pins"] = {{{"particles", {0}}}};
    scene["bodies"][0]["constraints"] = {{{"type", "distance"}, {"elements", {"edges"}}}};
    scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"pc2", "obj"}}};
    run_quietly(scene, {.out = folder_ / "out", .steps = kLast});
  }

  /// Blender has z up: its x y z are x -z y of malha. A float of some 3 m is off by 2e-7 m.
  void expect_places(const Json& found, const std::vector<Vec3>& x, std::size_t first) const {
    for (std::size_t v = 0; v < found.size(); ++v) {
      EXPECT_NEAR(found[v][0].get<double>(), x.at(first + v)[0], 1e-6) << "vertex " << v;
      EXPECT_NEAR(found[v][1].get<double>(), -x.at(first + v)[2], 1e-6) << "vertex " << v;
      EXPECT_NEAR(found[v][2].get<double>(), x.at(first + v)[1], 1e-6) << "vertex " << v;
    }
  }

  static constexpr int kLast = 12;  // frame
  static inline const std::string kScript = MALHA_SOURCE_DIR "/tools/examples/blender.py";
  const std::string blender_ = program_on_path("blender");
  TemporaryFolder folder_;
};

TEST_F(Blender, PlaysTheRunOnTheObjectsThatWereExportedAndChangesNothingElseOfThem) {
  simulate();
  blend(folder_ / "garment.blend", kScript,
        {"apply", folder_ / "out/frames", "--save", folder_ / "animated.blend", "--render", folder_ / "frame.png",
         "--frame", "10", "--size", "64", "36"});
  blend("", folder_.write("look.py", kLook),
        {folder_ / "garment.blend", folder_ / "animated.blend", folder_ / "found.json", std::to_string(kLast + 1)});
  const Json found = Json::parse(bytes_of(folder_ / "found.json"));
  Json before = found["before"], after = found["after"];
  EXPECT_EQ(after["Cape of wool"]["modifiers"].dump(), R"([["malha","MESH_CACHE"],["fine","SUBSURF"]])");
  for (Json* one : {&before, &after})
    for (Json& object : *one) object.erase("modifiers");
  EXPECT_EQ(before.dump(), after.dump());
  ASSERT_EQ(found["frames"].size(), std::size_t{kLast} + 1);
  for (int k = 0; k <= kLast; ++k) {
    const std::string number = std::to_string(k + 1000000).substr(1);
    const std::vector<Vec3> x = read_mesh((folder_ / ("out/frames/frame_" + number + ".obj")).string()).points;
    ASSERT_EQ(found["frames"][std::size_t(k)].size(), x.size());
    expect_places(found["frames"][std::size_t(k)], x, 0);
  }
  EXPECT_TRUE(bytes_of(folder_ / "frame.png").starts_with("\x89PNG"));
}

TEST_F(Blender, ImportsTheObjectsAtRestWithTheirTextureCoordinatesAndCaches) {
  simulate();
  const std::string frames = folder_ / "out/frames";
  blend("", folder_.write("import.py", kImport), {frames, folder_ / "found.json", std::to_string(kLast)});
  const Json found = Json::parse(bytes_of(folder_ / "found.json"));
  const FileMesh last = read_file_mesh(frames + "/frame_000012.obj", {}, Attributes::All);
  std::size_t vertex = 0, polygon = 0;
  for (const char* name : {"Cape_of_wool", "Hood"}) {
    const Json& object = found[name];
    expect_places(object["places"], last.mesh.points, vertex);
    vertex += object["places"].size();
    std::size_t corner = 0;
    for (const Json& size : object["polygons"]) {
      const auto corners = last.polygons.corners_of(polygon);
      ASSERT_EQ(size.get<std::size_t>(), corners.size());
      for (std::size_t k = 0; k < corners.size(); ++k, ++corner) {
        const auto uv = static_cast<std::size_t>(
            last.polygons.corner_uv[static_cast<std::size_t>(last.polygons.begin[polygon]) + k]);
        for (std::size_t c = 0; c < 2; ++c)
          EXPECT_EQ(object["texture"][corner][c].get<float>(), static_cast<float>(last.polygons.uv[uv][c]));
      }
      ++polygon;
    }
  }
  EXPECT_EQ(vertex, last.mesh.points.size());
  EXPECT_EQ(polygon, last.polygons.count());
  EXPECT_EQ(found["Cape_of_wool"]["materials"].dump(), R"(["Wool","Lining"])");
}

}  // namespace
}  // namespace malha
