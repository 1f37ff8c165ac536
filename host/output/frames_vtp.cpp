// SPDX-License-Identifier: Apache-2.0
// VTK PolyData writer: one XML file with raw appended data a frame, and a .pvd collection that gives each its time.
// (VTK File Formats, kitware: "XML File Formats", appended data.) Each array is a 64-bit byte count and its values.
#include <charconv>
#include <cstdint>

#include "host/base/file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// Cells of one kind in VTK's layout: the corners of all cells, and the end offset of each cell.
struct Cells {
  std::vector<std::int32_t> corners, ends;

  void add(std::span<const int> cell) {
    corners.insert(corners.end(), cell.begin(), cell.end());
    ends.push_back(static_cast<std::int32_t>(corners.size()));
  }
};

template <class T>
void append_array(std::string& bytes, std::span<const T> values) {
  append(bytes, static_cast<std::uint64_t>(values.size_bytes()));
  append_all(bytes, values);
}

/// The XML of a frame, and the appended bytes that all frames share.
class Document {
 public:
  explicit Document(const FrameTopology& topology) : in_double_(topology.in_double) {
    Cells verts, lines, polys;
    for (const int point : topology.loose) verts.add(std::array{point});
    for (const auto& line : topology.lines) lines.add(line);
    for (std::size_t f = 0; f < topology.polygons.count(); ++f) polys.add(topology.polygons.corners_of(f));
    const auto count = [](std::size_t n) { return "\"" + std::to_string(n) + "\""; };
    xml_ =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "<PolyData>\n<Piece NumberOfPoints=" +
        count(topology.rest.size()) + " NumberOfVerts=" + count(verts.ends.size()) +
        " NumberOfLines=" + count(lines.ends.size()) +
        " NumberOfStrips=\"0\" NumberOfPolys=" + count(polys.ends.size()) + ">\n";
    const std::string number = in_double_ ? "Float64" : "Float32";
    const std::size_t vectors = sizeof(std::uint64_t) + bytes_each() * topology.rest.size();
    xml_ += "<Points>\n" + data_array(number, "points", 3, 0) + "</Points>\n";
    xml_ += "<PointData Vectors=\"velocity\">\n" + data_array(number, "velocity", 3, vectors) + "</PointData>\n";
    offset_ = 2 * vectors;
    add("Verts", verts);
    add("Lines", lines);
    add("Polys", polys);
    xml_ += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  }

  void put(const Frame& frame, std::string& bytes) const {
    bytes = xml_;
    append_vectors(bytes, frame.points);
    append_vectors(bytes, frame.velocities);
    bytes += cells_;
    bytes += "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::size_t bytes_each() const { return in_double_ ? 24 : 12; }
  void append_vectors(std::string& bytes, std::span<const Vec3> values) const {
    append(bytes, static_cast<std::uint64_t>(bytes_each() * values.size()));
    for (const Vec3& x : values) append(bytes, x, in_double_);
  }

  static std::string data_array(const std::string& type, const std::string& name, int components, std::size_t offset) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
  }

  void add(const std::string& kind, const Cells& cells) {
    xml_ += "<" + kind + ">\n";
    for (const auto& [name, values] : {std::pair{"connectivity", &cells.corners}, std::pair{"offsets", &cells.ends}}) {
      xml_ += data_array("Int32", name, 1, offset_);
      const std::size_t before = cells_.size();
      append_array(cells_, std::span<const std::int32_t>(*values));
      offset_ += cells_.size() - before;
    }
    xml_ += "</" + kind + ">\n";
  }

  bool in_double_;
  std::string xml_, cells_;
  std::size_t offset_ = 0;  // bytes of appended data so far
};

constexpr char kEntry[] = "<DataSet timestep=\"", kFile[] = "\" file=\"";

class Vtp : public FrameFormat {
 public:
  Vtp(fs::path folder, const FrameTopology& topology, int next) : folder_(std::move(folder)), document_(topology) {
    if (next > 0) frames_ = collected_frames(folder_);
    std::erase_if(frames_, [next](const CollectedFrame& frame) { return frame.index >= next; });
    write_collection();  // written before the frames are removed, so that it never names a missing one
    drop_frames(folder_, ".vtp", next);
  }

  void write(const Frame& frame) override {
    document_.put(frame, bytes_);
    write_whole(folder_ / frame_name(frame.index, ".vtp"), bytes_);
    frames_.push_back({frame.index, frame.time});
    write_collection();
  }

 private:
  void write_collection() const {
    std::string entries;
    for (const auto& [index, time] : frames_) {
      char digits[32];
      const auto end = std::to_chars(digits, digits + sizeof digits, time).ptr;
      entries += kEntry + std::string(digits, end) + kFile + frame_name(index, ".vtp") + "\"/>\n";
    }
    write_whole(folder_ / "frames.pvd",
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                "<Collection>\n" +
                    entries + "</Collection>\n</VTKFile>\n");
  }

  fs::path folder_;
  Document document_;
  std::string bytes_;  // of the last frame; kept, because new memory pages cost more than the copies
  std::vector<CollectedFrame> frames_;
};

}  // namespace

std::vector<CollectedFrame> collected_frames(const fs::path& folder) {
  std::vector<CollectedFrame> frames;
  if (!fs::exists(folder / "frames.pvd")) return frames;
  const std::string text = read_input(folder / "frames.pvd", "a folder of results of malha run"), file = kFile;
  for (std::size_t at = text.find(kEntry); at != std::string::npos; at = text.find(kEntry, at + 1)) {
    CollectedFrame frame{};
    const auto [end, error] = std::from_chars(&text[at] + sizeof kEntry - 1, text.data() + text.size(), frame.time);
    const std::size_t name = static_cast<std::size_t>(end - text.data()) + file.size();
    if (error != std::errc{} || text.compare(name - file.size(), file.size(), file) != 0) continue;
    frame.index = frame_index(text.substr(name, text.find('"', name) - name), ".vtp");
    if (frame.index >= 0) frames.push_back(frame);
  }
  return frames;
}

std::unique_ptr<FrameFormat> make_vtp(const fs::path& folder, const FrameTopology& topology, int next) {
  return std::make_unique<Vtp>(folder, topology, next);
}

}  // namespace malha
