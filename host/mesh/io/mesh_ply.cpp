// SPDX-License-Identifier: Apache-2.0
// Reader of PLY files (Stanford): ascii, binary_little_endian, binary_big_endian. Elements other than vertex and face,
// and properties other than x, y, z and the corners, are skipped.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "host/mesh/io/mesh_formats.h"
#include "host/mesh/io/mesh_ply_header.h"
#include "host/mesh/polygons.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace ply {
namespace {

// The item that is being read, such as a vertex or a face.
struct Item {
  const Element* element = nullptr;
  long long index = 0;

  std::string text() const {
    return element->name + " " + std::to_string(index) + " (0-based) of " + std::to_string(element->count);
  }
};

// Values of an ascii body, which has one item per line.
class AsciiValues {
 public:
  explicit AsciiValues(const TextScanner& scan) : scan_(scan) {}

  std::size_t line() const { return scan_.line(); }
  std::size_t bytes_left() const { return scan_.bytes_left() + 1; }  // the last line may have no line end
  static std::size_t bytes_of(Type) { return 2; }                    // a digit and a separator
  void begin(const Item& item) {
    if (!scan_.next_line()) scan_.refuse_end(item.text());
  }
  void end() { scan_.require_end_of_line("as many values as the header says"); }
  double real(Type) { return scan_.real("a coordinate"); }
  long long integer(Type) { return scan_.integer("a count or an index"); }
  void skip(Type) { scan_.word("a value"); }
  bool at_end() { return !scan_.next_line(); }
  [[noreturn]] void refuse_value(const std::string& found, const std::string& allowed) {
    scan_.refuse_here(found, allowed);
  }

 private:
  TextScanner scan_;
};

// Values of a binary body, one after the other.
class BinaryValues {
 public:
  BinaryValues(const std::string& file, std::string_view data, std::size_t start, std::endian order)
      : file_(file), scan_(file, data, start, order), value_at_(start) {}

  static std::size_t line() { return 0; }
  std::size_t bytes_left() const { return scan_.bytes_left(); }
  static std::size_t bytes_of(Type type) { return size_of(type); }
  void begin(const Item& item) { item_ = item; }
  void end() {}
  double real(Type type) {
    const double value = number<double>(type);
    if (!std::isfinite(value)) refuse_value("a NaN or infinite coordinate in " + item_.text(), "finite numbers");
    return value;
  }
  long long integer(Type type) { return number<long long>(type); }
  void skip(Type type) {
    require(type);
    scan_.skip(size_of(type));
  }
  bool at_end() {
    value_at_ = scan_.offset();
    return scan_.bytes_left() == 0;
  }
  [[noreturn]] void refuse_value(const std::string& found, const std::string& allowed) {
    refuse(file_, "byte " + std::to_string(value_at_), found, allowed);
  }

 private:
  void require(Type type) {
    value_at_ = scan_.offset();
    if (scan_.bytes_left() < size_of(type)) scan_.refuse_end(item_.text());
  }

  template <class Number>
  Number number(Type type) {
    require(type);
    switch (type) {
      case Type::Int8:
        return static_cast<Number>(scan_.get<std::int8_t>());
      case Type::Uint8:
        return static_cast<Number>(scan_.get<std::uint8_t>());
      case Type::Int16:
        return static_cast<Number>(scan_.get<std::int16_t>());
      case Type::Uint16:
        return static_cast<Number>(scan_.get<std::uint16_t>());
      case Type::Int32:
        return static_cast<Number>(scan_.get<std::int32_t>());
      case Type::Uint32:
        return static_cast<Number>(scan_.get<std::uint32_t>());
      case Type::Float32:
        return static_cast<Number>(scan_.get<float>());
      default:
        return static_cast<Number>(scan_.get<double>());
    }
  }

  std::string file_;
  ByteScanner scan_;
  std::size_t value_at_;
  Item item_;
};

template <class Values>
long long read_list_size(Values& values, const Property& property) {
  const long long size = values.integer(*property.count);
  if (size < 0) values.refuse_value("a list of " + std::to_string(size) + " values", "0 or more");
  return size;
}

template <class Values>
void read_corners(Values& values, const Property& property, long long vertices, std::vector<int>& face) {
  const long long size = read_list_size(values, property);
  if (size < 3) values.refuse_value("a face of " + std::to_string(size) + " corners", "3 or more");
  face.clear();
  for (long long k = 0; k < size; ++k) {
    const long long index = values.integer(property.type);
    if (index < 0 || index >= vertices) {
      values.refuse_value("vertex " + std::to_string(index), "0 to " + std::to_string(vertices - 1));
    }
    face.push_back(static_cast<int>(index));
  }
}

// Refuses an element that the rest of the file cannot hold. This is checked before any allocation.
template <class Values>
void require_capacity(const std::string& file, const Element& element, const Values& values) {
  std::size_t each = 0;
  for (const Property& property : element.properties) each += values.bytes_of(property.count.value_or(property.type));
  const std::size_t most = values.bytes_left() / std::max<std::size_t>(each, 1);
  if (static_cast<unsigned long long>(element.count) > most) {
    refuse(file, element.place, std::to_string(element.count) + " items of element " + malha::quoted(element.name),
           "at most " + std::to_string(most) + ", as many as the rest of the file can hold");
  }
}

template <class Values>
Mesh read_body(const std::string& file, const Header& header, Values values) {
  Mesh mesh;
  PolygonList polygons;
  std::vector<int> face;
  for (const Element& element : header.elements) {
    require_capacity(file, element, values);
    if (element.has(0)) mesh.points.reserve(static_cast<std::size_t>(element.count));
    if (element.has(corners)) polygons.reserve(static_cast<std::size_t>(element.count));
    for (long long i = 0; i < element.count; ++i) {
      values.begin({&element, i});
      Vec3 point{};
      for (const Property& property : element.properties) {
        if (property.role == corners) {
          read_corners(values, property, header.vertices, face);
          polygons.add(face, values.line());
        } else if (property.role != skipped) {
          point[static_cast<std::size_t>(property.role)] = values.real(property.type);
        } else {
          const long long size = property.count ? read_list_size(values, property) : 1;
          for (long long k = 0; k < size; ++k) values.skip(property.type);
        }
      }
      if (element.name == "vertex") mesh.points.push_back(point);
      values.end();
    }
  }
  if (!values.at_end()) values.refuse_value("data after the last item", "as many items as the header says");
  polygons.append_to(mesh, file);
  return mesh;
}

}  // namespace
}  // namespace ply

Mesh read_ply(const std::string& file, std::string_view data) {
  TextScanner scan(file, data);
  const ply::Header header = ply::read_header(file, scan);
  if (header.format == "ascii") return ply::read_body(file, header, ply::AsciiValues(scan));
  const auto order = header.format == "binary_little_endian" ? std::endian::little : std::endian::big;
  return ply::read_body(file, header, ply::BinaryValues(file, data, scan.offset(), order));
}

}  // namespace malha
