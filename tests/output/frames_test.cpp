// SPDX-License-Identifier: Apache-2.0
// Formats of frames: each is read back by a small reader written here from the format's own description, without our
// writer.
#include "host/output/frames.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "host/base/file.h"

namespace malha {
namespace {

namespace fs = std::filesystem;
using P = std::array<float, 3>;

constexpr double kThird = 1.0 / 3;

std::vector<P> to_floats(const std::vector<Vec3>& points) {
  std::vector<P> floats;
  for (const Vec3& p : points) floats.push_back({float(p[0]), float(p[1]), float(p[2])});
  return floats;
}
std::vector<Vec3> to_doubles(const std::vector<P>& points) {
  std::vector<Vec3> doubles;
  for (const P& p : points) doubles.push_back({p[0], p[1], p[2]});
  return doubles;
}

class Frames : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "malha_frames_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A quad and a triangle that share an edge, a line of two segments, one loose particle.
  static FrameTopology topology() {
    FrameTopology all{
        polygons_of({{0, 1, 2, 3}, {1, 4, 2, -1}}),
        {{5, 6}, {6, 7}},
        {8},
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0.5f, 0}, {0, 2, 0}, {1, 2, 0}, {2, 2, 0}, {3, 3, 3}}};
    all.meshes = {{"sheet", 0, 0, 0}};
    return all;
  }

  /// Points and velocities that differ from frame to frame and do not round to anything short.
  static std::vector<P> moved(int frame, float offset = 0) {
    auto points = to_floats(topology().rest);
    for (auto& p : points) p = {p[0] + 0.1f * float(frame) + offset, p[1] / 3, -p[2] - 1e-7f * float(frame)};
    return points;
  }
  /// The same points, with digits that no float has.
  static std::vector<Vec3> moved_in_double(int frame, double offset = 0) {
    std::vector<Vec3> points = topology().rest;
    for (Vec3& p : points) p = {p[0] + 0.1 * frame + offset, p[1] / 3 + 1e-11, -p[2] * kThird - 1e-17 * frame};
    return points;
  }

  void write(FrameWriter& writer, int frame) const {
    writer.write(0.25 * frame, to_doubles(moved(frame)), to_doubles(moved(frame, 7)));
  }
  void write_in_double(const std::vector<std::string>& formats) const {
    FrameTopology exact = topology();
    exact.in_double = true;
    for (Vec3& p : exact.rest) p[1] = kThird;
    FrameWriter(folder_, formats, exact).write(0, moved_in_double(2), moved_in_double(2, 7));
  }

  void run(const std::vector<std::string>& formats, int from, int to) const {
    FrameWriter writer(folder_, formats, topology(), from);
    for (int frame = from; frame < to; ++frame) write(writer, frame);
    EXPECT_EQ(writer.next(), to);
  }

  std::string read(const std::string& name) const { return read_whole(folder_ / name); }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_)) all.push_back(entry.path().filename().string());
    std::sort(all.begin(), all.end());
    return all;
  }

  fs::path folder_;
};

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <class T>
std::vector<T> many(const std::string& bytes, std::size_t offset, std::size_t count) {
  std::vector<T> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(at<T>(bytes, offset + i * sizeof(T)));
  return values;
}

/// The value of `key="..."` that follows `from` in an XML text.
std::string attribute(const std::string& xml, const std::string& from, const std::string& key) {
  const auto start = xml.find(key + "=\"", xml.find(from));
  if (start == std::string::npos) return "absent";
  const auto value = start + key.size() + 2;
  return xml.substr(value, xml.find('"', value) - value);
}

/// A raw appended array of a VTK XML file: a 64-bit byte count at its offset after the underscore, then the values.
template <class T>
std::vector<T> vtk_array(const std::string& file, const std::string& section, const std::string& name) {
  const auto start = file.find("_", file.find("<AppendedData encoding=\"raw\">")) + 1;
  const auto after = file.find("<" + section);
  const auto element = file.find("Name=\"" + name + "\"", after);
  const auto offset = start + std::stoul(attribute(file.substr(element), "", "offset"));
  return many<T>(file, offset + 8, at<std::uint64_t>(file, offset) / sizeof(T));
}

using Ints = std::vector<std::int32_t>;

TEST_F(Frames, VtpHoldsPointsVelocitiesAndCells) {
  run({"vtp"}, 0, 2);
  const std::string file = read("frame_000001.vtp");
  EXPECT_EQ(attribute(file, "<VTKFile", "type"), "PolyData");
  EXPECT_EQ(attribute(file, "<VTKFile", "byte_order"), "LittleEndian");
  EXPECT_EQ(attribute(file, "<VTKFile", "header_type"), "UInt64");
  EXPECT_EQ(attribute(file, "<Piece", "NumberOfPoints"), "9");
  EXPECT_EQ(attribute(file, "<Piece", "NumberOfVerts"), "1");
  EXPECT_EQ(attribute(file, "<Piece", "NumberOfLines"), "2");
  EXPECT_EQ(attribute(file, "<Piece", "NumberOfPolys"), "2");
  EXPECT_EQ(vtk_array<P>(file, "Points", "points"), moved(1));
  EXPECT_EQ(vtk_array<P>(file, "PointData", "velocity"), moved(1, 7));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Polys", "connectivity"), (Ints{0, 1, 2, 3, 1, 4, 2}));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Polys", "offsets"), (Ints{4, 7}));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Lines", "connectivity"), (Ints{5, 6, 6, 7}));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Lines", "offsets"), (Ints{2, 4}));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Verts", "connectivity"), (Ints{8}));
  EXPECT_EQ(vtk_array<std::int32_t>(file, "Verts", "offsets"), (Ints{1}));
}

/// The frames that a .pvd lists, and their times.
std::map<std::string, double> collection(const std::string& pvd) {
  std::map<std::string, double> frames;
  std::istringstream lines(pvd);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("<DataSet") == std::string::npos) continue;
    frames[attribute(line, "", "file")] = std::stod(attribute(line, "", "timestep"));
  }
  return frames;
}

TEST_F(Frames, PvdIsValidAfterEveryFrame) {
  FrameWriter writer(folder_, {"vtp"}, topology());
  for (int frame = 0; frame < 4; ++frame) {
    write(writer, frame);
    const std::string pvd = read("frames.pvd");
    EXPECT_EQ(pvd.substr(pvd.size() - 11), "</VTKFile>\n");
    const auto frames = collection(pvd);
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(frame + 1));
    for (const auto& [name, time] : frames) EXPECT_TRUE(fs::exists(folder_ / name));
    EXPECT_EQ(frames.rbegin()->second, 0.25 * frame);
  }
}

TEST_F(Frames, Pc2HeaderCountsEveryFrameAsItIsWritten) {
  FrameWriter writer(folder_, {"pc2"}, topology());
  for (int frame = 0; frame < 3; ++frame) {
    const std::string file = read("points_sheet.pc2");
    EXPECT_EQ(file.substr(0, 12), std::string("POINTCACHE2\0", 12));
    EXPECT_EQ(at<std::int32_t>(file, 12), 1);      // version
    EXPECT_EQ(at<std::int32_t>(file, 16), 9);      // points
    EXPECT_EQ(at<float>(file, 20), 0.0f);          // first frame
    EXPECT_EQ(at<float>(file, 24), 1.0f);          // frames per sample
    EXPECT_EQ(at<std::int32_t>(file, 28), frame);  // samples
    ASSERT_EQ(file.size(), 32u + static_cast<std::size_t>(frame) * 9 * 12);
    for (int i = 0; i < frame; ++i) {
      EXPECT_EQ(many<P>(file, 32 + static_cast<std::size_t>(i) * 9 * 12, 9), moved(i));
    }
    write(writer, frame);
  }
}

/// The contents of an OBJ file: element lines by their letter.
struct ObjFile {
  std::string name;  // of its object
  std::vector<Vec3> points;
  std::map<std::string, std::vector<Ints>> elements;

  explicit ObjFile(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string kind, word;
      words >> kind;
      if (kind == "v") {
        Vec3 p{};
        for (double& x : p) words >> word, x = std::strtod(word.c_str(), nullptr);
        points.push_back(p);
      } else if (kind == "o") {
        std::getline(words >> std::ws, name);
      } else {
        Ints corners;
        while (words >> word) corners.push_back(std::stoi(word));
        elements[kind].push_back(corners);
      }
    }
  }
};

const std::map<std::string, std::vector<Ints>> kObjElements{
    {"f", {{1, 2, 3, 4}, {2, 5, 3}}}, {"l", {{6, 7}, {7, 8}}}, {"p", {{9}}}};

// Blender drops vertices that no face and no line uses: the loose particle is a line of no length.
TEST_F(Frames, RestObjBesideThePointCacheKeepsOrderAndQuads) {
  run({"pc2"}, 0, 1);
  const ObjFile rest(read("rest.obj"));
  EXPECT_EQ(rest.points, topology().rest);
  const std::map<std::string, std::vector<Ints>> expected{{"f", {{1, 2, 3, 4}, {2, 5, 3}}},
                                                          {"l", {{6, 7}, {7, 8}, {9, 9}}}};
  EXPECT_EQ(rest.elements, expected);
  EXPECT_EQ(rest.name, "sheet");
}

TEST_F(Frames, ObjReadsBackToTheSameFloats) {
  run({"obj"}, 0, 3);
  const ObjFile frame(read("frame_000002.obj"));
  EXPECT_EQ(to_floats(frame.points), moved(2));
  EXPECT_EQ(frame.elements, kObjElements);
}

TEST_F(Frames, InDoubleReadBackToTheBit) {
  write_in_double({"vtp", "ply", "obj", "pc2"});
  const std::string vtp = read("frame_000000.vtp"), ply = read("frame_000000.ply");
  EXPECT_EQ(attribute(vtp, "<Points", "type"), "Float64");
  EXPECT_EQ(attribute(vtp, "<PointData", "type"), "Float64");
  EXPECT_EQ(vtk_array<Vec3>(vtp, "Points", "points"), moved_in_double(2));
  EXPECT_EQ(vtk_array<Vec3>(vtp, "PointData", "velocity"), moved_in_double(2, 7));
  EXPECT_EQ(vtk_array<std::int32_t>(vtp, "Polys", "connectivity"), (Ints{0, 1, 2, 3, 1, 4, 2}));
  EXPECT_NE(ply.find("property double x\nproperty double y\nproperty double z\nproperty double vx\n"),
            std::string::npos);
  std::vector<Vec3> points, velocities;
  std::size_t place = ply.find("end_header\n") + 11;
  for (int i = 0; i < 9; ++i, place += 48)
    points.push_back(at<Vec3>(ply, place)), velocities.push_back(at<Vec3>(ply, place + 24));
  EXPECT_EQ(points, moved_in_double(2));
  EXPECT_EQ(velocities, moved_in_double(2, 7));
  EXPECT_EQ(ply.size(), place + 46) << "faces and edges as ever";
  EXPECT_EQ(ObjFile(read("frame_000000.obj")).points, moved_in_double(2));
  EXPECT_EQ(ObjFile(read("rest.obj")).points[4], (Vec3{2, kThird, 0}));
  EXPECT_EQ(many<P>(read("points_sheet.pc2"), 32, 9), to_floats(moved_in_double(2))) << "the format knows floats only";
}

TEST_F(Frames, PlyHoldsPointsVelocitiesFacesAndEdges) {
  run({"ply"}, 0, 2);
  const std::string file = read("frame_000001.ply");
  const auto end = file.find("end_header\n");
  EXPECT_EQ(file.substr(0, end),
            "ply\nformat binary_little_endian 1.0\ncomment object 0 sheet\nelement vertex 9\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property float vx\nproperty float vy\nproperty float vz\n"
            "element face 2\nproperty list uchar int vertex_indices\n"
            "element edge 2\nproperty int vertex1\nproperty int vertex2\n");
  std::size_t place = end + 11;
  for (std::size_t i = 0; i < 9; ++i, place += 24) {
    EXPECT_EQ(at<P>(file, place), moved(1)[i]);
    EXPECT_EQ(at<P>(file, place + 12), moved(1, 7)[i]);
  }
  EXPECT_EQ(at<std::uint8_t>(file, place), 4);
  EXPECT_EQ(many<std::int32_t>(file, place + 1, 4), (Ints{0, 1, 2, 3}));
  EXPECT_EQ(at<std::uint8_t>(file, place + 17), 3);
  EXPECT_EQ(many<std::int32_t>(file, place + 18, 3), (Ints{1, 4, 2}));
  EXPECT_EQ(many<std::int32_t>(file, place + 30, 4), (Ints{5, 6, 6, 7}));
  EXPECT_EQ(file.size(), place + 46);
}

TEST_F(Frames, ContinuedRunLeavesTheSameFilesAsAnUninterruptedOne) {
  const std::vector<std::string> all{"vtp", "pc2", "ply", "obj"};
  run(all, 0, 6);
  std::map<std::string, std::string> whole;
  for (const auto& name : names()) whole[name] = read(name);
  EXPECT_EQ(whole.size(), 3u * 6 + 3);

  run(all, 0, 5);  // a fresh run over the old one: frame 5 must go
  EXPECT_EQ(names().size(), 3u * 5 + 3);
  run(all, 3, 6);  // a run to frame 4, continued from frame 3
  std::map<std::string, std::string> continued;
  for (const auto& name : names()) continued[name] = read(name);
  EXPECT_EQ(continued, whole);
}

TEST_F(Frames, OnlyItsOwnFramesAreRemoved) {
  const std::vector<std::string> others{"frame_1.ply", "frame_000001.obj", "frame_x00001.ply", "my.ply",
                                        "frame_000001.ply.bak"};
  for (const auto& name : others) write_whole(folder_ / name, "mine");
  write_whole(folder_ / "frame_000001.ply", "old");
  const FrameWriter writer(folder_, {"ply"}, topology());
  for (const auto& name : others) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_FALSE(fs::exists(folder_ / "frame_000001.ply"));
}

TEST_F(Frames, ContinuingIntoAnEmptyFolderStartsAtThatFrame) {
  run({"vtp", "pc2"}, 7, 9);
  const std::string cache = read("points_sheet.pc2");
  EXPECT_EQ(at<float>(cache, 20), 7.0f);
  EXPECT_EQ(at<std::int32_t>(cache, 28), 2);
  EXPECT_EQ(collection(read("frames.pvd")),
            (std::map<std::string, double>{{"frame_000007.vtp", 1.75}, {"frame_000008.vtp", 2.0}}));
  run({"pc2"}, 8, 10);  // the first frame of the cache is honoured
  EXPECT_EQ(at<std::int32_t>(read("points_sheet.pc2"), 28), 3);
  EXPECT_EQ(many<P>(read("points_sheet.pc2"), 32 + 2 * 108, 9), moved(9));
}

/// The message of the std::runtime_error that `act` throws.
template <class F>
std::string complaint(F&& act) {
  try {
    act();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST_F(Frames, PointCacheThatDoesNotContinueIsRefusedAndKept) {
  run({"pc2"}, 0, 2);
  const std::string before = read("points_sheet.pc2");
  const auto continue_at_five = [&] { FrameWriter(folder_, {"pc2"}, topology(), 5); };
  EXPECT_EQ(complaint(continue_at_five),
            (folder_ / "points_sheet.pc2").string() + ": does not continue at frame 5: found frames 0 to 1");
  EXPECT_EQ(read("points_sheet.pc2"), before);
  write_whole(folder_ / "points_sheet.pc2", "POINTCACHE2");
  EXPECT_NE(complaint(continue_at_five).find("found no point cache of 9 points"), std::string::npos);
  EXPECT_EQ(read("points_sheet.pc2"), "POINTCACHE2");
}

TEST_F(Frames, FullDiskIsAnErrorThatNamesTheFileAndKeepsEarlierFrames) {
  FrameWriter writer(folder_, {"vtp", "pc2"}, topology());
  write(writer, 0);
  const std::string series = read("frames.pvd");
  // /dev/full refuses every byte with ENOSPC; the temporary file beside the frame leads there.
  fs::create_symlink("/dev/full", folder_ / "frame_000001.vtp.tmp");
  EXPECT_EQ(complaint([&] { write(writer, 1); }),
            (folder_ / "frame_000001.vtp").string() + ": cannot write: No space left on device");
  EXPECT_EQ(read("frames.pvd"), series);
  EXPECT_FALSE(fs::exists(folder_ / "frame_000001.vtp"));
  EXPECT_FALSE(fs::is_symlink(folder_ / "frame_000001.vtp.tmp"));

  fs::remove(folder_ / "points_sheet.pc2");
  fs::create_symlink("/dev/full", folder_ / "points_sheet.pc2");
  EXPECT_EQ(complaint([&] { write(writer, 1); }),
            (folder_ / "points_sheet.pc2").string() + ": cannot write: No space left on device");
}

TEST_F(Frames, FolderThatCannotBeMadeIsAnErrorThatNamesIt) {
  write_whole(folder_ / "file", "in the way");
  const fs::path under = folder_ / "file" / "frames";
  EXPECT_EQ(complaint([&] { FrameWriter(under, {"ply"}, topology()); }),
            under.string() + ": cannot make the folder: Not a directory");
  EXPECT_NE(complaint([&] { FrameWriter(folder_ / "file", {"ply"}, topology()); }).find("file: cannot make the folder"),
            std::string::npos);
}

TEST_F(Frames, WrongNumberOfPointsAndUnknownFormatsAreRefused) {
  FrameWriter writer(folder_, {"obj"}, topology());
  const std::vector<Vec3> nine(9), eight(8);
  EXPECT_THROW(writer.write(0, eight, nine), std::invalid_argument);
  EXPECT_THROW(writer.write(0, nine, eight), std::invalid_argument);
  EXPECT_THROW(FrameWriter(folder_, {"gltf"}, topology()), std::invalid_argument);
  EXPECT_EQ(writer.next(), 0);
}

}  // namespace
}  // namespace malha
