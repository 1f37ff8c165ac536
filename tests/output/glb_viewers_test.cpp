// SPDX-License-Identifier: Apache-2.0
// A run as glTF in three.js (in Chromium) and Blender: the positions that they show, against its frames in another
// format.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "host/base/file.h"
#include "host/output/page_pack.h"
#include "tests/output/browser.h"
#include "tests/output/glb_scene.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

/// The scene's frames, and the vertices' positions in a viewer at the time of each.
class GlbIn : public testing::Test {
 protected:
  GlbIn() { run_quietly(glb_scene(folder_), {.out = (folder_ / "out").string()}); }

  ObjOfFrame frame(int k) const { return {folder_ / "out/frames", k}; }
  fs::path file() const { return folder_ / "out/frames/run.glb"; }

  TemporaryFolder folder_;
};

/// A page that loads the file, and returns the vertices' positions at the time of a frame: as the loader's own
/// animation sets them, and as its renderer adds them up.
std::string page_of(const std::string& glb) {
  const std::string three = "file://" THREE_FOLDER;
  return "<!doctype html><meta charset=utf-8><script src='" + three + "/three.min.js'></script><script src='" + three +
         "/examples/js/loaders/GLTFLoader.js'></script><script>\nconst bytes = Uint8Array.from(atob('" + base64(glb) +
         R"JS('), (letter) => letter.charCodeAt(0));
window.malha = {};
// Debian's three.js is release 111. Lines have had targets since 117, and animations of lines and points since 135.
THREE.Line.prototype.updateMorphTargets = THREE.Points.prototype.updateMorphTargets;
const objects = {};
let action, mixer, times, scene;
const renderer = new THREE.WebGLRenderer({preserveDrawingBuffer: true});
renderer.setSize(400, 300);
const camera = new THREE.PerspectiveCamera(50, 4 / 3, 0.1, 100);
camera.position.set(0, 2, 9);
function show(frame) {
  action.reset();
  action.time = times[frame];
  mixer.update(0);
  for (const object of Object.values(objects))
    if (!object.isMesh) object.morphTargetInfluences.splice(0, 1e9, ...objects.patchwork.morphTargetInfluences);
  scene.updateMatrixWorld(true);
}
function places(object) {
  const {position} = object.geometry.attributes, moved = object.geometry.morphAttributes.position || [];
  const all = [];
  for (let i = 0; i < position.count; ++i) {
    const x = new THREE.Vector3().fromBufferAttribute(position, i);
    moved.forEach((target, k) => {
      const weight = object.morphTargetInfluences[k];
      if (weight) x.addScaledVector(new THREE.Vector3().fromBufferAttribute(target, i), weight);
    });
    all.push(x.applyMatrix4(object.matrixWorld).toArray());
  }
  return all;
}
function picture(frame) {
  show(frame);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * 400 * 300);
  gl.readPixels(0, 0, 400, 300, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}
new THREE.GLTFLoader().parse(bytes.buffer, '', (file) => {
  scene = file.scene;
  scene.add(new THREE.AmbientLight(0xffffff, 1));
  for (const object of scene.children) if (object.geometry) objects[object.name] = object;
  mixer = new THREE.AnimationMixer(scene);
  action = mixer.clipAction(file.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  times = file.animations[0].tracks[0].times;
  malha.ready = malha.drawn = true;
}, (error) => { malha.error = String(error); });
</script>)JS";
}

TEST_F(GlbIn, ThreeJsIsTheRunAtTheTimeOfEachFrame) {
  if (Browser::command().empty()) GTEST_SKIP() << "no chromium: tools/setup browser";
  Browser browser(600, 400);
  browser.open(folder_.write("page.html", page_of(bytes_of(file()))));
  const auto value = [&](const std::string& expression) {
    return Json::parse(browser.evaluate("JSON.stringify(" + expression + ")").get<std::string>());
  };
  EXPECT_EQ(value("Object.keys(objects).sort()").dump(),
            R"(["ball","dust","ground","patchwork","rope","sheet_of_quads"])");
  ASSERT_EQ(value("Array.from(times)").size(), std::size_t{kGlbFrames});
  const std::vector<Vec3> start = frame(0).points;
  const Json ball_at_start = value("(show(0), places(objects.ball))");
  for (int k = 0; k < kGlbFrames; ++k) {
    const std::string shown = "(show(" + std::to_string(k) + "), ";
    const Json places =
        value(shown + "[].concat(...['patchwork', 'sheet_of_quads', 'rope', 'dust'].map((n) => places(objects[n]))))");
    const std::vector<Vec3> x = frame(k).points;
    ASSERT_EQ(places.size(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)  // half a float of the displacement; three.js adds in double
        ASSERT_NEAR(places[i][c].get<double>(), x[i][c], kHalfAFloat * (std::fabs(x[i][c] - start[i][c]) + 1e-6))
            << "vertex " << i << " of frame " << k;
    const Json ball = value(shown + "places(objects.ball))");
    for (std::size_t i = 0; i < ball.size(); ++i) {
      const Vec3 at_start = ball_at_start[i];
      const Vec3 expected = on_the_ball(at_start, k * kGlbStep);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(ball[i][c].get<double>(), expected[c], 1e-6) << "floats of 3 m";
    }
  }
  // The page also draws them: many pixels differ from the background, and others do at another time.
  value("(window.one = picture(0), window.other = picture(24), 0)");
  EXPECT_GT(value("one.filter((byte, i) => i % 4 < 3 && byte > 0).length").get<int>(), 3000);
  EXPECT_GT(value("one.filter((byte, i) => byte !== other[i]).length").get<int>(), 3000);
  EXPECT_TRUE(browser.complaints().empty()) << browser.complaints()[0];
}

// Blender has z up: its x y z are x -z y of the file. Origins of objects are at the middle of their bodies.
constexpr char kBlenderScript[] = R"PY(
import json, sys
try:
    import numpy
except ImportError:
    sys.exit(77)
if not hasattr(numpy, 'bool'):
    numpy.bool = bool  # Debian 12 has a numpy that has lost what its Blender's importer names
import bpy
glb, out, frames, rate = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = int(rate)
bpy.ops.import_scene.gltf(filepath=glb)
found = []
for k in range(int(frames)):
    bpy.context.scene.frame_set(k)
    graph = bpy.context.evaluated_depsgraph_get()
    objects = {}
    for thing in bpy.data.objects:
        if thing.type != 'MESH':
            continue
        seen = thing.evaluated_get(graph)
        mesh = seen.to_mesh()
        turned = seen.matrix_world.to_3x3()
        places = [turned @ v.co for v in mesh.vertices]
        objects[thing.name] = {
            'at': [seen.matrix_world.translation[c] for c in (0, 2, 1)],
            'places': [[p[0], p[2], p[1]] for p in places],
            'faces': [list(face.vertices) for face in mesh.polygons]}
        seen.to_mesh_clear()
    found.append(objects)
with open(out, 'w') as file:
    json.dump(found, file)
)PY";

TEST_F(GlbIn, BlenderIsTheRunAtEachFrame) {
  const std::string blender = program_on_path("blender");
  if (blender.empty()) GTEST_SKIP() << "no blender: tools/setup blender";
  const std::string script = folder_.write("look.py", kBlenderScript), found = (folder_ / "found.json").string();
  const Ended ended = MalhaProcess({"--background", "--factory-startup", "--python-exit-code", "1", "--python", script,
                                    "--", file().string(), found, std::to_string(kGlbFrames), "48"},
                                   folder_ / "", RLIM_INFINITY, blender)
                          .wait();
  if (ended.status == 77) GTEST_SKIP() << "Blender's importer needs python3-numpy";
  ASSERT_EQ(ended.status, 0) << ended.out << ended.err;
  const Json all = Json::parse(bytes_of(found));
  ASSERT_EQ(all.size(), std::size_t{kGlbFrames});

  const ObjOfFrame first = frame(0);
  std::set<int> used;  // Blender drops vertices that no element uses
  for (const auto* elements : {&first.faces, &first.lines, &first.loose})
    for (const auto& element : *elements) used.insert(element.begin(), element.end());
  EXPECT_LT(used.size(), first.points.size());
  for (int k = 0; k < kGlbFrames; ++k) {
    const std::vector<Vec3> x = frame(k).points;
    auto vertex = used.begin();
    for (const char* name : {"patchwork", "sheet of quads", "rope", "dust"}) {
      const Json& body = all[k][name];
      for (const Json& place : body["places"]) {
        ASSERT_NE(vertex, used.end());
        for (std::size_t c = 0; c < 3; ++c) {
          const double sign = c == 2 ? -1 : 1, local = place[c], middle = body["at"][c];
          const double start = first.points[*vertex][c], moved = std::fabs(x[*vertex][c] - start);
          // The file rounds displacements. Blender rounds start + displacement, less start, plus start; each to a
          // float.
          ASSERT_NEAR(sign * (local + middle), x[*vertex][c],
                      kHalfAFloat * (2 * moved + 2 * std::fabs(local) + std::fabs(start - sign * middle)) + 1e-12)
              << name << " vertex " << *vertex << " of frame " << k;
        }
        ++vertex;
      }
    }
    EXPECT_EQ(vertex, used.end());
    const Json &ball = all[k]["ball"], &before = all[0]["ball"];
    ASSERT_EQ(ball["places"].size(), 162u);
    for (std::size_t i = 0; i < 162; ++i) {
      const auto there = [i](const Json& object, std::size_t c) {
        return (c == 2 ? -1 : 1) * (object["places"][i][c].get<double>() + object["at"][c].get<double>());
      };
      const Vec3 expected = on_the_ball({there(before, 0), there(before, 1), there(before, 2)}, k * kGlbStep);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(there(ball, c), expected[c], 3e-6) << "floats of 3 m, turned";
    }
  }
}

}  // namespace
}  // namespace malha
