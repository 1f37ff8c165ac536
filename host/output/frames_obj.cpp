// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ writer: one text file a frame.
#include <charconv>

#include "host/base/file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace {

template <class T>
void append_number(std::string& text, T value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;  // shortest that reads back the same
  text += ' ';
  text.append(digits, end);
}

template <class Corners>
void append_element(std::string& text, char kind, const Corners& corners) {
  text += kind;
  for (const int corner : corners) {
    if (corner >= 0) append_number(text, corner + 1);
  }
  text += '\n';
}

class Obj : public FrameFormat {
 public:
  Obj(std::filesystem::path folder, const FrameTopology& topology)
      : folder_(std::move(folder)), elements_(obj_elements(topology)), in_double_(topology.in_double) {}

  void write(const Frame& frame) override {
    write_whole(folder_ / frame_name(frame.index, ".obj"), obj_text(frame.points, in_double_, elements_));
  }

 private:
  std::filesystem::path folder_;
  std::string elements_;
  bool in_double_;
};

}  // namespace

std::string obj_elements(const FrameTopology& topology) {
  std::string text;
  for (const auto& face : topology.faces) append_element(text, 'f', face);
  for (const auto& line : topology.lines) append_element(text, 'l', line);
  for (const int point : topology.loose) append_element(text, 'p', std::array{point});
  return text;
}

std::string obj_text(std::span<const Vec3> points, bool in_double, const std::string& elements) {
  std::string text;
  text.reserve(points.size() * (in_double ? 60 : 36) + elements.size());
  for (const auto& point : points) {
    text += 'v';
    for (const double x : point) in_double ? append_number(text, x) : append_number(text, static_cast<float>(x));
    text += '\n';
  }
  return text + elements;
}

std::unique_ptr<FrameFormat> make_obj(const std::filesystem::path& folder, const FrameTopology& topology, int next) {
  drop_frames(folder, ".obj", next);
  return std::make_unique<Obj>(folder, topology);
}

}  // namespace malha
