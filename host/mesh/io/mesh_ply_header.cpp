// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_ply_header.h"

#include "malha/error.h"
#include "malha/text.h"

namespace malha::ply {
namespace {

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

}  // namespace

std::size_t size_of(Type type) {
  constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<int>(type)];
}

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

}  // namespace malha::ply
