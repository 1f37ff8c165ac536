// Wavefront OBJ, one text file a frame.
#include <charconv>

#include "host/base/file.h"
#include "host/results/frame_formats.h"

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
      : folder_(std::move(folder)), elements_(obj_elements(topology)) {}

  void write(const Frame& frame) override {
    write_whole(folder_ / frame_name(frame.index, ".obj"), obj_text(frame.points, elements_));
  }

 private:
  std::filesystem::path folder_;
  std::string elements_;
};

}  // namespace

std::string obj_elements(const FrameTopology& topology) {
  std::string text;
  for (const auto& face : topology.faces) append_element(text, 'f', face);
  for (const auto& line : topology.lines) append_element(text, 'l', line);
  for (const int point : topology.loose) append_element(text, 'p', std::array{point});
  return text;
}

std::string obj_text(std::span<const std::array<float, 3>> points, const std::string& elements) {
  std::string text;
  text.reserve(points.size() * 36 + elements.size());
  for (const auto& point : points) {
    text += 'v';
    for (const float x : point) append_number(text, x);
    text += '\n';
  }
  return text + elements;
}

std::unique_ptr<FrameFormat> make_obj(const std::filesystem::path& folder, const FrameTopology& topology, int next) {
  drop_frames(folder, ".obj", next);
  return std::make_unique<Obj>(folder, topology);
}

}  // namespace malha
