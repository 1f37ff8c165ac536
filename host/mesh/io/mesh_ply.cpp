// SPDX-License-Identifier: Apache-2.0
// Reader of PLY files (Stanford): ascii, binary_little_endian, binary_big_endian. Elements other than vertex and face,
// and properties other than x, y, z, the corners and the vertices' colours, are skipped.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "host/mesh/polygons.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace ply {
namespace {

enum class Type { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

/// Bytes of a value.
std::size_t size_of(Type type) {
  constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<int>(type)];
}

/// Use of a property: x, y, z (0, 1, 2), the corners of a face, red, green, blue and alpha (4 to 7), or skipped.
enum Role { skipped = -1, corners = 3, colour = 4 };

struct Property {
  std::string name;
  Type type = Type::Int8;
  std::optional<Type> count;  // type of the count of a list; none: a scalar
  int role = skipped;
};

/// A sequence of items with the same properties, such as vertices or faces.
struct Element {
  std::string name;
  long long count = 0;
  std::vector<Property> properties;
  std::string place;  // of its count in the header, for messages

  bool has(int role) const { return std::ranges::find(properties, role, &Property::role) != properties.end(); }
};

struct Header {
  std::string format;  // ascii, binary_little_endian or binary_big_endian
  std::vector<Element> elements;
  long long vertices = 0;  // count of the element "vertex"
};

struct TypeName {
  const char* name;
  Type type;
};
constexpr TypeName type_names[] = {
    {"char", Type::Int8},     {"int8", Type::Int8},       {"uchar", Type::Uint8},    {"uint8", Type::Uint8},
    {"short", Type::Int16},   {"int16", Type::Int16},     {"ushort", Type::Uint16},  {"uint16", Type::Uint16},
    {"int", Type::Int32},     {"int32", Type::Int32},     {"uint", Type::Uint32},    {"uint32", Type::Uint32},
    {"float", Type::Float32}, {"float32", Type::Float32}, {"double", Type::Float64}, {"float64", Type::Float64}};

bool is_integer(Type type) { return type != Type::Float32 && type != Type::Float64; }

Type read_type(TextScanner& scan) {
  const std::string_view name = scan.word("a type");
  const auto known = std::ranges::find(type_names, name, &TypeName::name);
  if (known == std::end(type_names)) {
    scan.refuse_word(name, "char, uchar, short, ushort, int, uint, float, double or int8 to float64");
  }
  return known->type;
}

int role_of(const std::string& element, const Property& property) {
  if (element == "vertex" && !property.count && property.name.size() == 1) {
    const auto axis = std::string_view("xyz").find(property.name);
    return axis == std::string_view::npos ? skipped : static_cast<int>(axis);
  }
  if (element == "vertex" && !property.count) {
    constexpr std::string_view channels[]{"red", "green", "blue", "alpha"};
    const auto channel = std::ranges::find(channels, property.name);
    if (channel != std::end(channels)) return colour + static_cast<int>(channel - channels);
  }
  const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
  return element == "face" && property.count && is_integer(property.type) && is_corners ? corners : skipped;
}

Property read_property(TextScanner& scan, const std::string& element) {
  Property property;
  if (TextScanner(scan).word("a type") == "list") {
    scan.word("");
    property.count = read_type(scan);
    if (!is_integer(*property.count))
      scan.refuse_here("a list with a count of a floating-point type", "a count of an integer type");
  }
  property.type = read_type(scan);
  property.name = scan.word("a name");
  property.role = role_of(element, property);
  return property;
}

// Refuses headers other than those with one vertex element with x, y, z and at most one face element with corners.
void require_elements(const std::string& file, const TextScanner& scan, Header& header) {
  for (const char* name : {"vertex", "face"}) {
    const auto matches = std::ranges::count(header.elements, std::string_view(name), &Element::name);
    if (matches > 1) scan.refuse_here("a header with more than one element " + quoted(name), "one");
  }
  const auto vertex = std::ranges::find(header.elements, std::string_view("vertex"), &Element::name);
  if (vertex == header.elements.end()) scan.refuse_here("a header without element \"vertex\"", "one");
  header.vertices = vertex->count;
  if (!vertex->has(0) || !vertex->has(1) || !vertex->has(2)) {
    refuse(file, vertex->place, "an element \"vertex\" without x, y and z", "properties x, y and z");
  }
  const auto face = std::ranges::find(header.elements, std::string_view("face"), &Element::name);
  if (face != header.elements.end() && !face->has(corners)) {
    refuse(file, face->place, "an element \"face\" without corners",
           "a list vertex_indices (or vertex_index) of an integer type");
  }
}

/// Reads the header up to and including the line end_header. The result has one element "vertex" with x, y, z, and at
/// most one element "face", with a list of corners. Throws InputError.
Header read_header(const std::string& file, TextScanner& scan) {
  Header header;
  const bool any = scan.next_line();
  if (!any || scan.word("") != "ply") scan.refuse_here("no PLY header", "\"ply\" on the first line");
  while (true) {
    if (!scan.next_line()) scan.refuse_end("end_header");
    const std::string_view keyword = scan.word("");
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "format") {
      header.format = scan.word("a format");
      if (header.format != "ascii" && header.format != "binary_little_endian" && header.format != "binary_big_endian") {
        scan.refuse_word(header.format, "ascii, binary_little_endian or binary_big_endian");
      }
    } else if (keyword == "element") {
      Element element;
      element.name = scan.word("a name");
      element.count = scan.integer("a count");
      element.place = scan.place();
      if (element.count < 0) scan.refuse_here(std::to_string(element.count), "a count of 0 or more");
      header.elements.push_back(std::move(element));
    } else if (keyword == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property(scan, header.elements.back().name));
    } else {
      scan.refuse_word(keyword, "format, comment, element, property (after an element) or end_header");
    }
  }
  if (header.format.empty()) scan.refuse_here("a header without format", "format ascii 1.0, or binary");
  require_elements(file, scan, header);
  return header;
}

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
      : scan_(file, data, start, order) {}

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
    require(size_of(type));
    scan_.skip(size_of(type));
  }
  bool at_end() {
    require(0);
    return scan_.bytes_left() == 0;
  }
  [[noreturn]] void refuse_value(const std::string& found, const std::string& allowed) {
    scan_.refuse_value(found, allowed);
  }

 private:
  void require(std::size_t bytes) {
    scan_.begin_value(bytes, [this] { return item_.text(); });
  }

  template <class Number>
  Number number(Type type) {
    require(size_of(type));
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

  ByteScanner scan_;
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
FileMesh read_body(const std::string& file, const Header& header, Values values, bool reads_colours) {
  FileMesh read;
  Mesh& mesh = read.mesh;
  Polygons& polygons = read.polygons;
  std::vector<int> face;
  for (const Element& element : header.elements) {
    require_capacity(file, element, values);
    if (element.has(0)) mesh.points.reserve(static_cast<std::size_t>(element.count));
    if (element.has(corners)) polygons.begin.reserve(static_cast<std::size_t>(element.count) + 1);
    for (long long i = 0; i < element.count; ++i) {
      values.begin({&element, i});
      Vec3 point{};
      std::array<float, 4> tint{1, 1, 1, 1};
      for (const Property& property : element.properties) {
        if (property.role == corners) {
          read_corners(values, property, header.vertices, face);
          polygons.add(face);
          if (const std::size_t line = values.line(); line > 0) polygons.line.push_back(line);
        } else if (property.role >= colour && reads_colours) {
          // Integers are parts of the largest one.
          const double most =
              is_integer(property.type) ? std::ldexp(1.0, 8 * static_cast<int>(size_of(property.type))) - 1 : 1;
          tint[static_cast<std::size_t>(property.role - colour)] =
              static_cast<float>(values.real(property.type) / most);
        } else if (property.role != skipped && property.role < colour) {
          point[static_cast<std::size_t>(property.role)] = values.real(property.type);
        } else {
          const long long size = property.count ? read_list_size(values, property) : 1;
          for (long long k = 0; k < size; ++k) values.skip(property.type);
        }
      }
      if (element.name == "vertex") mesh.points.push_back(point);
      if (reads_colours && element.has(colour)) read.colours.push_back(tint);
      values.end();
    }
  }
  if (!values.at_end()) values.refuse_value("data after the last item", "as many items as the header says");
  return read;
}

}  // namespace
}  // namespace ply

FileMesh read_ply(const std::string& file, std::string_view data, Attributes attributes) {
  const bool reads_colours = attributes == Attributes::All;
  TextScanner scan(file, data);
  const ply::Header header = ply::read_header(file, scan);
  if (header.format == "ascii") return ply::read_body(file, header, ply::AsciiValues(scan), reads_colours);
  const auto order = header.format == "binary_little_endian" ? std::endian::little : std::endian::big;
  return ply::read_body(file, header, ply::BinaryValues(file, data, scan.offset(), order), reads_colours);
}

}  // namespace malha
