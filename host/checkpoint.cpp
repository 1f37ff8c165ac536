#include "host/checkpoint.h"

#include <cstring>
#include <filesystem>

#include "host/error.h"
#include "host/file.h"
#include "host/hash.h"

namespace malha {

namespace {

constexpr char kMagic[] = "malha checkpoint 1\n";  // its size keeps what follows readable in a hex dump

struct Header {
  std::uint64_t scene, state;  // hashes
};

std::uint64_t hash_scene(const Model& model) {
  Scene scene = model.scene;
  scene.name = "-";
  scene.duration = 1;
  scene.outputs = {};
  scene.expect = {};
  const auto forget_folder = [](Shape& shape) {
    if (auto* mesh = std::get_if<MeshFile>(&shape)) mesh->path = std::filesystem::path(mesh->path).filename();
  };
  for (BodySpec& body : scene.bodies) forget_folder(body.shape);
  for (EnvironmentSpec& environment : scene.environment) forget_folder(environment.shape);
  const std::string json = to_json(scene);
  // The points stand for the mesh files' contents.
  std::uint64_t hash = hash_bytes(json.data(), json.size());
  hash = hash_bytes(model.x.data(), model.x.size() * sizeof(Vec3), hash);
  for (const EnvironmentMesh& mesh : model.environment)
    hash = hash_bytes(mesh.mesh.points.data(), mesh.mesh.points.size() * sizeof(Vec3), hash);
  return hash;
}

}  // namespace

void write_checkpoint(const std::string& path, const Model& model, const std::string& state) {
  const Header header{hash_scene(model), hash_bytes(state.data(), state.size())};
  write_whole(path, kMagic + std::string(reinterpret_cast<const char*>(&header), sizeof header) + state);
}

std::string read_checkpoint(const std::string& path, const Model& model) {
  std::string bytes;
  try {
    bytes = read_whole(path);
  } catch (const std::runtime_error& error) {
    throw InputError(error.what());
  }
  const std::size_t magic = sizeof kMagic - 1;
  Header header;
  if (bytes.compare(0, magic, kMagic) != 0 || bytes.size() < magic + sizeof header)
    refuse(path, "byte 0", "no checkpoint of this version", "a file that malha run wrote");
  std::memcpy(&header, bytes.data() + magic, sizeof header);
  const std::string state = bytes.substr(magic + sizeof header);
  if (header.state != hash_bytes(state.data(), state.size()))
    refuse(path, "byte " + std::to_string(magic), "a damaged checkpoint", "one whose bytes match their hash");
  if (header.scene != hash_scene(model))
    refuse(path, "", "a checkpoint of another scene", "one of this scene with the same bodies, solver and environment");
  return state;
}

}  // namespace malha
