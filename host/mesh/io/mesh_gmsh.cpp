// SPDX-License-Identifier: Apache-2.0
// Reader of Gmsh's .msh files, ASCII and binary, versions 2.2 and 4.1, with triangles, quads and tetrahedra of first
// order. Points keep the order of the file, in which their numbers are arbitrary. Sections without geometry are
// skipped.
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "host/mesh/io/mesh_formats.h"
#include "host/mesh/io/mesh_scan.h"
#include "malha/error.h"

namespace malha {
namespace gmsh {
namespace {

// Readers of the values of a file in text (one item per line) and in binary, with a common interface for the sections.

class TextValues {
 public:
  explicit TextValues(TextScanner& scan) : scan_(scan) {}

  void begin(const std::string& wanted) {
    if (!scan_.next_line()) scan_.refuse_end(wanted);
  }
  /// Starts item i of n.
  void begin(const char* item, long long i, long long n) {
    if (!scan_.next_line()) scan_.refuse_end(item + (" " + std::to_string(i + 1)) + " of " + std::to_string(n));
  }
  void end(const std::string& what) { scan_.require_end_of_line(what); }
  long long whole(const char* wanted) { return scan_.integer(wanted); }
  long long tag(const char* wanted) { return scan_.integer(wanted); }
  double real(const char* wanted) { return scan_.real(wanted); }
  /// A number of items with this many integers, tags and reals each; refused if the rest of the file cannot hold them.
  long long count(const char* wanted, int wholes, int tags, int reals) {
    return scan_.count(wanted, 2 * (wholes + tags + reals));  // a digit and a separator
  }
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const {
    scan_.refuse_here(found, allowed);
  }

 private:
  TextScanner& scan_;
};

class ByteValues {
 public:
  /// `tag_bytes` is the size of counts and of the numbers of nodes and elements in version 4.1: 4 or 8.
  ByteValues(const std::string& file, std::string_view data, std::size_t start, std::endian order,
             std::size_t tag_bytes)
      : file_(file), scan_(file, data, start, order), tag_bytes_(tag_bytes), value_at_(start) {}

  std::size_t offset() const { return scan_.offset(); }
  void begin(const std::string&) { item_ = nullptr; }
  void begin(const char* item, long long i, long long n) { item_ = item, index_ = i, of_ = n; }
  void end(const std::string&) {}
  long long whole(const char* wanted) { return number<std::int32_t>(wanted); }
  long long tag(const char* wanted) {
    if (tag_bytes_ == 4) return number<std::uint32_t>(wanted);
    const std::uint64_t value = number<std::uint64_t>(wanted);
    if (value >> 63) refuse_here(std::to_string(value) + " as " + wanted, "a number below 2^63");
    return static_cast<long long>(value);
  }
  double real(const char* wanted) {
    const double value = number<double>(wanted);
    if (!std::isfinite(value)) refuse_here("a NaN or infinite " + std::string(wanted), "a finite number");
    return value;
  }
  long long count(const char* wanted, int wholes, int tags, int reals) {
    const long long count = tag(wanted);
    const std::size_t each = 4 * wholes + tag_bytes_ * tags + 8 * reals;
    const auto most = static_cast<long long>(scan_.bytes_left() / each);
    if (count > most)
      refuse_here(std::to_string(count) + " as " + wanted,
                  "0 to " + std::to_string(most) + ", as many as the rest of the file can hold");
    return count;
  }
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const {
    refuse(file_, "byte " + std::to_string(value_at_), found, allowed);
  }

 private:
  template <class T>
  T number(const char* wanted) {
    value_at_ = scan_.offset();
    if (scan_.bytes_left() < sizeof(T))
      scan_.refuse_end(
          wanted +
          (item_ ? std::string(" of ") + item_ + " " + std::to_string(index_ + 1) + " of " + std::to_string(of_) : ""));
    return scan_.get<T>();
  }

  std::string file_;
  ByteScanner scan_;
  std::size_t tag_bytes_, value_at_;
  const char* item_ = nullptr;  // kind of the item that is being read, which is item index_ of of_
  long long index_ = 0, of_ = 0;
};

class GmshReader {
 public:
  GmshReader(const std::string& file, std::string_view data) : file_(file), data_(data), scan_(file, data) {}

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
        version_ == 2 ? read_nodes_2() : with_values([this](auto& values) { read_nodes_4(values); });
        require_end(section);
      } else if (section == "Elements") {
        if (!nodes) scan_.refuse_word(name, "$Nodes before it");
        if (elements) scan_.refuse_word(name, "one section $Elements");
        elements = true;
        version_ == 2 ? read_elements_2() : with_values([this](auto& values) { read_elements_4(values); });
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
    const long long type = scan_.integer("the file type");
    if (type != 0 && type != 1)
      scan_.refuse_here(std::to_string(type) + " as the file type", "0 (ASCII) or 1 (binary)");
    const long long bytes = scan_.integer("the size of a number");
    if (type == 1) {
      if (bytes != 8 && !(version_ == 4 && bytes == 4))
        scan_.refuse_here("numbers of " + std::to_string(bytes) + " bytes", version_ == 4 ? "8 or 4" : "8");
      tag_bytes_ = static_cast<std::size_t>(bytes);
      read_order();
    }
    require_end("MeshFormat");
  }

  /// Finds the byte order of a binary file, which is given by the integer 1.
  void read_order() {
    const std::size_t at = scan_.offset();
    scan_.seek(at);
    if (data_.size() - at < 4) scan_.refuse_end("the integer 1 in four bytes, which gives the byte order");
    for (const std::endian order : {std::endian::little, std::endian::big})
      if (ByteScanner(file_, data_, at, order).get<std::int32_t>() == 1) order_ = order;
    if (!order_)
      scan_.refuse_here("four bytes that are not the integer 1 in either byte order",
                        "the integer 1, which gives the byte order");
    scan_.seek(at + 4);
  }

  /// Version 2.2 has the number of items as text, then one item per line; in binary all nodes, and elements in blocks
  /// of one type.
  void read_nodes_2() {
    line("the number of nodes");
    const long long n = scan_.count("the number of nodes", order_ ? 28 : 8);
    reserve(n);
    with_values([&](auto& values) {
      for (long long i = 0; i < n; ++i) {
        values.begin("node", i, n);
        number_node(values, values.whole("the number of a node"));
        add_point(values);
        values.end("a node's number, x, y, z");
      }
    });
  }
  void read_elements_2() {
    line("the number of elements");
    const long long n = scan_.count("the number of elements", 8);
    with_values([&](auto& values) {
      for (long long i = 0; i < n;) {
        values.begin("element", i, n);
        if (!order_) values.whole("the number of an element");
        const int type = read_type(values);
        const long long in_block = order_ ? values.whole("the number of elements in a block") : 1;
        if (in_block < 1 || in_block > n - i)
          values.refuse_here(std::to_string(in_block) + " elements in a block", "1 to " + std::to_string(n - i));
        const long long tags = values.whole("the number of tags");
        if (tags < 0) values.refuse_here(std::to_string(tags) + " tags", "0 or more");
        for (const long long end = i + in_block; i < end; ++i) {
          if (order_) values.begin("element", i, n), values.whole("the number of an element");
          for (long long k = 0; k < tags; ++k) values.whole("a tag");
          read_corners(values, type, [&] { return values.whole("a corner"); });
        }
      }
    });
  }

  /// Version 4.1 has blocks of items of one geometric entity; blocks of nodes have first the numbers, then the
  /// positions.
  template <class Values>
  void read_nodes_4(Values& values) {
    const auto [blocks, n] = read_totals(values, "nodes");
    reserve(n);
    long long read = 0;
    for (long long b = 0; b < blocks; ++b) {
      values.begin("block", b, blocks);
      const long long dimension = values.whole("the dimension of an entity");
      values.whole("the number of an entity");
      const long long parametric = values.whole("0 or 1 (parametric)");
      if (dimension < 0 || dimension > 3)
        values.refuse_here("an entity of dimension " + std::to_string(dimension), "0 to 3");
      if (parametric != 0 && parametric != 1)
        values.refuse_here(std::to_string(parametric) + " as parametric", "0 or 1");
      const long long size = values.count("the number of nodes in the block", 0, 1, 3);
      for (long long i = 0; i < size; ++i) {
        values.begin("the number of node", i, size);
        number_node(values, values.tag("the number of a node"));
        values.end("a node's number");
      }
      for (long long i = 0; i < size; ++i) {
        values.begin("node", i, size);
        add_point(values);
        for (long long k = 0; k < parametric * dimension; ++k) values.real("parameter");
        values.end("a node's x, y, z");
      }
      read += size;
    }
    if (read != n)
      values.refuse_here(std::to_string(read) + " nodes in all blocks", std::to_string(n) + ", as announced");
  }
  template <class Values>
  void read_elements_4(Values& values) {
    const auto [blocks, n] = read_totals(values, "elements");
    long long read = 0;
    for (long long b = 0; b < blocks; ++b) {
      values.begin("block", b, blocks);
      values.whole("the dimension of an entity");
      values.whole("the number of an entity");
      const int type = read_type(values);
      const long long size = values.count("the number of elements in the block", 0, 2, 0);
      for (long long i = 0; i < size; ++i) {
        values.begin("element", i, size);
        values.tag("the number of an element");
        read_corners(values, type, [&] { return values.tag("a corner"); });
      }
      read += size;
    }
    if (read != n)
      values.refuse_here(std::to_string(read) + " elements in all blocks", std::to_string(n) + ", as announced");
  }
  template <class Values>
  std::pair<long long, long long> read_totals(Values& values, const std::string& items) {
    values.begin("the numbers of blocks and " + items);
    const long long blocks = values.count("the number of blocks", 3, 1, 0);
    const long long n = values.count(("the number of " + items).c_str(), 0, 2, 0);
    values.tag("the lowest number"), values.tag("the highest number");
    values.end("the numbers of blocks and " + items + ", the lowest and the highest");
    return {blocks, n};
  }

  template <class Values>
  int read_type(Values& values) {
    const long long type = values.whole("the type of an element");
    if (!((1 <= type && type <= 4) || type == 15))
      values.refuse_here("an element of type " + std::to_string(type), std::string(kTypes) + "; all of first order");
    return static_cast<int>(type);
  }
  template <class Values, class Corner>
  void read_corners(Values& values, int type, Corner&& corner) {
    int at[4] = {-1, -1, -1, -1};
    const int corners = type == 15 ? 1 : type == 1 ? 2 : type == 2 ? 3 : 4;
    for (int k = 0; k < corners; ++k) {
      const long long number = corner();
      const auto found = index_of_.find(number);
      if (found == index_of_.end()) values.refuse_here("node " + std::to_string(number), "one of $Nodes");
      at[k] = found->second;
    }
    values.end("an element and its " + std::to_string(corners) + " nodes");
    if (type == 4) mesh_.tetrahedra.push_back({at[0], at[1], at[2], at[3]});
    if (type == 2 || type == 3) mesh_.faces.push_back({at[0], at[1], at[2], at[3]});
  }

  void reserve(long long n) {
    mesh_.points.reserve(static_cast<std::size_t>(n));
    index_of_.reserve(static_cast<std::size_t>(n));
  }
  template <class Values>
  void number_node(Values& values, long long number) {
    if (!index_of_.try_emplace(number, static_cast<int>(index_of_.size())).second)
      values.refuse_here("node " + std::to_string(number) + " again", "every node once");
  }
  template <class Values>
  void add_point(Values& values) {
    mesh_.points.push_back({values.real("x"), values.real("y"), values.real("z")});
  }

  /// Calls read() with a reader of the next values, in text or in binary.
  template <class Read>
  void with_values(Read&& read) {
    if (!order_) {
      TextValues values(scan_);
      return read(values);
    }
    ByteValues values(file_, data_, scan_.offset(), *order_, tag_bytes_);
    read(values);
    scan_.seek(values.offset());
  }

  void line(const std::string& wanted) {
    if (!scan_.next_line()) scan_.refuse_end(wanted);
  }
  void require_end(const std::string& section) {
    const std::string end = "$End" + section;
    line(end);
    if (const auto word = scan_.word(""); word != end) scan_.refuse_word(word, end);
  }
  void skip_to_end(const std::string& section) {
    const std::string end = "$End" + section;
    if (order_) return skip_bytes_to(end);
    do {
      line(end);
    } while (scan_.word("") != end);
  }
  /// Skips a binary file up to and including the first line that consists of this word.
  void skip_bytes_to(const std::string& end) {
    for (std::size_t at = scan_.offset(); (at = data_.find(end, at)) != data_.npos; ++at) {
      const std::size_t after = at + end.size();
      if (data_[at - 1] != '\n' || (after < data_.size() && data_[after] != '\n' && data_[after] != '\r')) continue;
      return scan_.seek(after);
    }
    scan_.seek(data_.size());
    scan_.refuse_end(end);
  }

  const std::string file_;
  const std::string_view data_;
  TextScanner scan_;
  Mesh mesh_;
  std::unordered_map<long long, int> index_of_;
  int version_ = 2;
  std::optional<std::endian> order_;  // byte order of a binary file; none: ASCII
  std::size_t tag_bytes_ = 8;         // size of tags in a binary file
};

}  // namespace
}  // namespace gmsh

Mesh read_gmsh(const std::string& file, std::string_view data) { return gmsh::GmshReader(file, data).read(); }

}  // namespace malha
