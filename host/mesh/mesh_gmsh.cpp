// Gmsh's .msh, ASCII, versions 2.2 and 4.1: triangles, quads and tetrahedra of first order. Points keep the file's
// order; its numbers for them may be any. Sections that say nothing about the shape are skipped.
#include <string>
#include <unordered_map>

#include "host/mesh/mesh_formats.h"
#include "host/mesh/mesh_scan.h"

namespace malha {
namespace {

class GmshReader {
 public:
  GmshReader(const std::string& file, std::string_view data) : scan_(file, data) {}

  Mesh read() {
    read_format();
    bool nodes = false, elements = false;
    while (scan_.next_line()) {
      const std::string_view name = scan_.word("");
      if (!name.starts_with('$')) scan_.refuse_word(name, "the beginning of a section: $Nodes, $Elements ...");
      const std::string section(name.substr(1));
      if (section.size() > kLongestName) scan_.refuse_word(name, "a section with a shorter name");
      if (section == "Nodes") {
        if (nodes) scan_.refuse_word(name, "one section $Nodes");
        nodes = true;
        version_ == 2 ? read_nodes_2() : read_nodes_4();
        require_end(section);
      } else if (section == "Elements") {
        if (!nodes) scan_.refuse_word(name, "$Nodes before it");
        if (elements) scan_.refuse_word(name, "one section $Elements");
        elements = true;
        version_ == 2 ? read_elements_2() : read_elements_4();
        require_end(section);
      } else {
        skip_to_end(section);
      }
    }
    if (!elements) scan_.refuse_end("a section $Elements");
    return std::move(mesh_);
  }

 private:
  static constexpr std::size_t kLongestName = 200;
  static constexpr const char* kTypes = "1 (line), 2 (triangle), 3 (quad), 4 (tetrahedron), 15 (point)";

  void read_format() {
    if (!scan_.next_line()) scan_.refuse_end("$MeshFormat");
    if (const auto word = scan_.word(""); word != "$MeshFormat") scan_.refuse_word(word, "$MeshFormat");
    line("the version");
    const std::string_view version = scan_.word("the version");
    if (version != "2.2" && version != "4.1") scan_.refuse_word(version, "version 2.2 or 4.1");
    version_ = version == "2.2" ? 2 : 4;
    if (scan_.integer("the file type") != 0)
      scan_.refuse_here("a binary file", "ASCII, file type 0 (gmsh -format msh41, without -bin)");
    scan_.integer("the size of a number");
    require_end("MeshFormat");
  }

  /// The lines of version 2.2: one an item, with its number.
  void read_nodes_2() {
    line("the number of nodes");
    const long long n = scan_.count("the number of nodes", 8);
    reserve(n);
    for (long long i = 0; i < n; ++i) {
      line("node", i, n);
      number_node(scan_.integer("the number of a node"));
      add_point();
      scan_.require_end_of_line("a node's number, x, y, z");
    }
  }
  void read_elements_2() {
    line("the number of elements");
    const long long n = scan_.count("the number of elements", 8);
    for (long long i = 0; i < n; ++i) {
      line("element", i, n);
      scan_.integer("the number of an element");
      const int type = read_type();
      const long long tags = scan_.count("the number of tags", 2);
      for (long long k = 0; k < tags; ++k) scan_.integer("a tag");
      read_corners(type);
    }
  }

  /// Those of 4.1: blocks of items of one geometric entity; of nodes first the numbers, then the places.
  void read_nodes_4() {
    const auto [blocks, n] = read_totals("nodes");
    reserve(n);
    long long read = 0;
    for (long long b = 0; b < blocks; ++b) {
      line("block", b, blocks);
      const long long dimension = scan_.integer("the dimension of an entity");
      scan_.integer("the number of an entity");
      const long long parametric = scan_.integer("0 or 1 (parametric)");
      if (dimension < 0 || dimension > 3) scan_.refuse_here("an entity of another dimension", "0 to 3");
      if (parametric != 0 && parametric != 1)
        scan_.refuse_here(std::to_string(parametric) + " as parametric", "0 or 1");
      const long long size = scan_.count("the number of nodes in the block", 8);
      for (long long i = 0; i < size; ++i) {
        line("the number of node", i, size);
        number_node(scan_.integer("the number of a node"));
        scan_.require_end_of_line("a node's number");
      }
      for (long long i = 0; i < size; ++i) {
        line("node", i, size);
        add_point();
        for (long long k = 0; k < parametric * dimension; ++k) scan_.real("a parameter");
        scan_.require_end_of_line("a node's x, y, z");
      }
      read += size;
    }
    if (read != n)
      scan_.refuse_here(std::to_string(read) + " nodes in all blocks", std::to_string(n) + ", as announced");
  }
  void read_elements_4() {
    const auto [blocks, n] = read_totals("elements");
    long long read = 0;
    for (long long b = 0; b < blocks; ++b) {
      line("block", b, blocks);
      scan_.integer("the dimension of an entity");
      scan_.integer("the number of an entity");
      const int type = read_type();
      const long long size = scan_.count("the number of elements in the block", 4);
      for (long long i = 0; i < size; ++i) {
        line("element", i, size);
        scan_.integer("the number of an element");
        read_corners(type);
      }
      read += size;
    }
    if (read != n)
      scan_.refuse_here(std::to_string(read) + " elements in all blocks", std::to_string(n) + ", as announced");
  }
  std::pair<long long, long long> read_totals(const std::string& items) {
    line("the numbers of blocks and " + items);
    const long long blocks = scan_.count("the number of blocks", 8);
    const long long n = scan_.count(("the number of " + items).c_str(), 4);
    scan_.integer("the lowest number"), scan_.integer("the highest number");
    scan_.require_end_of_line("the numbers of blocks and " + items + ", the lowest and the highest");
    return {blocks, n};
  }

  int read_type() {
    const long long type = scan_.integer("the type of an element");
    if (!((1 <= type && type <= 4) || type == 15))
      scan_.refuse_here("an element of type " + std::to_string(type), std::string(kTypes) + "; all of first order");
    return static_cast<int>(type);
  }
  void read_corners(int type) {
    int at[4] = {-1, -1, -1, -1};
    const int corners = type == 15 ? 1 : type == 1 ? 2 : type == 2 ? 3 : 4;
    for (int k = 0; k < corners; ++k) {
      const long long number = scan_.integer("a corner");
      const auto found = index_of_.find(number);
      if (found == index_of_.end()) scan_.refuse_here("node " + std::to_string(number), "one of $Nodes");
      at[k] = found->second;
    }
    scan_.require_end_of_line("an element and its " + std::to_string(corners) + " nodes");
    if (type == 4) mesh_.tetrahedra.push_back({at[0], at[1], at[2], at[3]});
    if (type == 2 || type == 3) mesh_.faces.push_back({at[0], at[1], at[2], at[3]});
  }

  void reserve(long long n) {
    mesh_.points.reserve(static_cast<std::size_t>(n));
    index_of_.reserve(static_cast<std::size_t>(n));
  }
  void number_node(long long number) {
    if (!index_of_.try_emplace(number, static_cast<int>(index_of_.size())).second)
      scan_.refuse_here("node " + std::to_string(number) + " again", "every node once");
  }
  void add_point() { mesh_.points.push_back({scan_.real("x"), scan_.real("y"), scan_.real("z")}); }

  void line(const std::string& wanted) {
    if (!scan_.next_line()) scan_.refuse_end(wanted);
  }
  /// Of item i of n.
  void line(const char* item, long long i, long long n) {
    if (!scan_.next_line()) scan_.refuse_end(item + (" " + std::to_string(i + 1)) + " of " + std::to_string(n));
  }
  void require_end(const std::string& section) {
    const std::string end = "$End" + section;
    line(end);
    if (const auto word = scan_.word(""); word != end) scan_.refuse_word(word, end);
  }
  void skip_to_end(const std::string& section) {
    const std::string end = "$End" + section;
    do {
      line(end);
    } while (scan_.word("") != end);
  }

  TextScanner scan_;
  Mesh mesh_;
  std::unordered_map<long long, int> index_of_;
  int version_ = 2;
};

}  // namespace

Mesh read_gmsh(const std::string& file, std::string_view data) { return GmshReader(file, data).read(); }

}  // namespace malha
