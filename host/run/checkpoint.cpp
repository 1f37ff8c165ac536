// SPDX-License-Identifier: Apache-2.0
#include "host/run/checkpoint.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "host/base/file.h"
#include "host/base/hash.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr char kMagic[] = "malha checkpoint 8\n";  // its size aligns the rest for a hex dump

struct Header {
  std::uint64_t scene, state;  // hashes
  std::int64_t frames, crossings, counted;
};

template <class T>
std::uint64_t hash_values(const std::vector<T>& values, std::uint64_t hash) {
  return hash_bytes(values.data(), values.size() * sizeof(T), hash);
}

}  // namespace

std::uint64_t scene_hash(const Model& model) {
  Scene scene = model.scene;
  scene.name = "-";
  scene.duration = 1;
  scene.outputs = {};
  scene.expect = {};
  bool has_maps = false;
  const auto forget_folder = [](auto* mesh) {
    if (mesh) mesh->path = std::filesystem::path(mesh->path).filename();
  };
  for (BodySpec& body : scene.bodies) {
    forget_folder(std::get_if<MeshFile>(&body.shape));
    if (body.rest) forget_folder(std::get_if<RestMesh>(&*body.rest));
    for_each_map(body,
                 [&](VertexMap& map) { map.picture = std::filesystem::path(map.picture).filename(), has_maps = true; });
  }
  for (EnvironmentSpec& environment : scene.environment) forget_folder(std::get_if<MeshFile>(&environment.shape));
  const std::string json = to_json(scene);
  std::uint64_t hash = hash_bytes(json.data(), json.size());
  // Points and constraints stand for the contents of the mesh files.
  hash = hash_values(model.x, hash);
  for (const Mesh& rest : model.render_mesh.rest) hash = hash_values(rest.points, hash_values(rest.faces, hash));
  for (const ConstraintSet& set : model.sets) hash = hash_values(set.particles, hash);
  if (has_maps) {
    for (const auto* sets : {&model.sets, &model.stencils})
      for (const ConstraintSet& set : *sets) hash = hash_values(set.parameters, hash_values(set.softness, hash));
    for (const SpringSet& set : model.springs) hash = hash_values(set.rest, hash_values(set.stiffness, hash));
    for (const auto* values : {&model.w, &model.friction_factor, &model.thickness_factor})
      hash = hash_values(*values, hash);
  }
  for (const PressureSet& set : model.pressures) hash = hash_values(set.triangles, hash);
  for (const FileVertices& file : model.render_mesh.vertices)
    hash = hash_values(file.point, hash);  // pins are given by vertices
  for (const EnvironmentMesh& mesh : model.environment)
    hash = hash_values(mesh.mesh.faces, hash_values(mesh.mesh.points, hash));
  return hash;
}

namespace {

std::uint64_t hash_state(const Checkpoint& checkpoint) {
  const std::int64_t counts[] = {checkpoint.frames, checkpoint.crossings, checkpoint.counted};
  return hash_bytes(checkpoint.state.data(), checkpoint.state.size(), hash_bytes(counts, sizeof counts));
}

}  // namespace

void write_checkpoint(const std::string& path, std::uint64_t scene, const Checkpoint& checkpoint) {
  const Header header{scene, hash_state(checkpoint), checkpoint.frames, checkpoint.crossings, checkpoint.counted};
  write_durably(path, {kMagic, {reinterpret_cast<const char*>(&header), sizeof header}, checkpoint.state});
}

Checkpoint read_checkpoint(const std::string& path, std::uint64_t scene) {
  std::string bytes = read_input(path, "a checkpoint that an earlier run left there");
  const std::size_t magic = sizeof kMagic - 1;
  Header header;
  const bool own = bytes.starts_with(kMagic);
  if (const std::string any(kMagic, magic - 2); !own && bytes.size() > magic && bytes.starts_with(any))
    refuse(path, "byte 0",
           "'" + printable(bytes.substr(0, std::min(bytes.find('\n'), magic))) + "', of another version of malha",
           "'" + std::string(kMagic, magic - 1) + "'; run the scene anew, or resume with the version that wrote it");
  if (!own || bytes.size() < magic + sizeof header)
    refuse(path, "byte 0", "no checkpoint", "a file that malha run wrote");
  std::memcpy(&header, bytes.data() + magic, sizeof header);
  bytes.erase(0, magic + sizeof header);  // in place, because a state may occupy half of the memory
  const Checkpoint checkpoint{std::move(bytes), header.frames, header.crossings, header.counted};
  if (header.state != hash_state(checkpoint))
    refuse(path, "byte " + std::to_string(magic), "a damaged checkpoint", "one whose bytes match their hash");
  if (header.scene != scene)
    refuse(path, "", "a checkpoint of another scene",
           "one of this scene with the same bodies, pins, solver, environment, and gravity and wind at the start");
  const auto check = [&](const char* what, std::int64_t count) {
    if (count < 0) refuse(path, what, std::to_string(count), "a whole number >= 0");
  };
  check("frames", header.frames), check("crossings", header.crossings), check("crossing checks", header.counted);
  return checkpoint;
}

namespace {
constexpr char kStateSignature[] = "malha state 1\n";
}

std::string with_state_header(const std::string& state, std::uint64_t scene) {
  const std::uint64_t hashes[] = {scene, hash_bytes(state.data(), state.size())};
  return kStateSignature + std::string(reinterpret_cast<const char*>(hashes), sizeof hashes) + state;
}

std::string without_state_header(const std::string& bytes, std::uint64_t scene) {
  std::uint64_t hashes[2];
  const std::size_t signature = sizeof kStateSignature - 1, head = signature + sizeof hashes;
  if (!bytes.starts_with(kStateSignature) || bytes.size() < head)
    refuse("state", "", counted(bytes.size(), "byte") + " that are no state", "what save_state() returned");
  std::memcpy(hashes, bytes.data() + signature, sizeof hashes);
  if (hashes[0] != scene) refuse("state", "", "a state of another scene", "one of this scene with the same pins");
  std::string state = bytes.substr(head);
  if (hashes[1] != hash_bytes(state.data(), state.size()))
    refuse("state", "", "a damaged state", "one whose bytes match their hash");
  return state;
}

}  // namespace malha
