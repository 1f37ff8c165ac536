// SPDX-License-Identifier: Apache-2.0
// Reader of OFF files (Geomview): [ST][C][N]OFF, counts, one vertex per line, one face per line. Normals, colours and
// texture coordinates are skipped.
#include <string>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/io/mesh_scan.h"
#include "host/mesh/polygons.h"

namespace malha {
namespace {

// Reads the header. Returns true if the lines of vertices have more than x y z.
bool read_header(TextScanner& scan) {
  if (!scan.next_line()) scan.refuse_end("a header: OFF, COFF or NOFF");
  const std::string_view header = scan.word("");
  std::string_view rest = header;
  for (const std::string_view prefix : {"ST", "C", "N"}) {
    if (rest.starts_with(prefix)) rest.remove_prefix(prefix.size());
  }
  if (rest != "OFF") scan.refuse_word(header, "a header: OFF, COFF or NOFF");
  return header != "OFF";
}

}  // namespace

FileMesh read_off(const std::string& file, std::string_view data) {
  TextScanner scan(file, data, '#');
  const bool extra = read_header(scan);
  if (!scan.has_word() && !scan.next_line()) scan.refuse_end("the numbers of vertices, faces and edges");
  const long long vertices = scan.count("the number of vertices", 6);  // "0 0 0\n"
  const long long faces = scan.count("the number of faces", 8);        // "3 0 1 2\n"
  if (scan.has_word()) scan.integer("the number of edges");
  scan.require_end_of_line("the numbers of vertices, faces and edges");

  FileMesh read;
  Mesh& mesh = read.mesh;
  mesh.points.reserve(static_cast<std::size_t>(vertices));
  Polygons& polygons = read.polygons;
  polygons.begin.reserve(static_cast<std::size_t>(faces) + 1);
  for (long long i = 0; i < vertices; ++i) {
    if (!scan.next_line()) scan.refuse_end("vertex " + std::to_string(i) + " (0-based) of " + std::to_string(vertices));
    mesh.points.push_back({scan.real("x"), scan.real("y"), scan.real("z")});
    if (!extra) scan.require_end_of_line("x, y, z");
  }
  std::vector<int> corners;
  for (long long i = 0; i < faces; ++i) {
    if (!scan.next_line()) scan.refuse_end("face " + std::to_string(i) + " (0-based) of " + std::to_string(faces));
    const long long size = scan.integer("the number of corners");
    if (size < 3) scan.refuse_here("a face of " + std::to_string(size) + " corners", "3 or more");
    corners.clear();
    for (long long k = 0; k < size; ++k) {
      const long long index = scan.integer("a corner");
      if (index < 0 || index >= vertices) {
        scan.refuse_here("vertex " + std::to_string(index), "0 to " + std::to_string(vertices - 1));
      }
      corners.push_back(static_cast<int>(index));
    }
    polygons.add(corners), polygons.line.push_back(scan.line());
  }
  if (scan.next_line()) {
    scan.word("");
    scan.refuse_here("a line after the last face", "as many lines as the header announces");
  }
  return read;
}

}  // namespace malha
