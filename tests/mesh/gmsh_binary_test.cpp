// SPDX-License-Identifier: Apache-2.0
// Gmsh's binary files: they give the same mesh as the text form, in either byte order, and no corrupt bytes cause a
// crash.
#include <gtest/gtest.h>

#include <random>

#include "host/mesh/io/mesh_io.h"
#include "malha/error.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

/// Two tetrahedra, a quad and a triangle next to them, a line and a point, and nodes whose numbers are in no order.
struct GmshMesh {
  std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0.1}, {0, 1, 1.0 / 3}, {0, 0.2, 1}, {1, 1.5, 1}, {2, 0, 0}, {2.5, 1, -1}};
  std::vector<int> numbers{10, 7, 3, 99, 1, 20, 8};
  std::vector<std::pair<int, std::vector<int>>> elements{{15, {10}},        {1, {10, 7}},    {3, {7, 20, 8, 1}},
                                                         {2, {20, 8, 1}},   {2, {7, 20, 1}}, {4, {10, 7, 3, 99}},
                                                         {4, {7, 3, 99, 1}}};
};

/// A block of elements of one type, from .. end - 1.
template <class F>
void each_block(const GmshMesh& mesh, F&& take) {
  for (std::size_t from = 0, end; from < mesh.elements.size(); from = end) {
    for (end = from; end < mesh.elements.size() && mesh.elements[end].first == mesh.elements[from].first;) ++end;
    take(from, end);
  }
}

/// The binary file: version 4.1 with counts of `size` bytes, or 2.2.
class GmshBytes {
 public:
  GmshBytes(bool big, int count_bytes, int version = 4) : big_(big), count_bytes_(count_bytes) {
    text_ = "$MeshFormat\n" + std::string(version == 2 ? "2.2" : "4.1") + " 1 " + std::to_string(count_bytes) + "\n";
    put(1);
    text_ += "\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"all\"\n$EndPhysicalNames\n";
    version == 2 ? write_2() : write_4();
  }
  std::string text() const { return text_; }

 private:
  void put(int value) { append(text_, std::int32_t{value}, big_); }
  void put(double value) { append(text_, value, big_); }
  void count(std::size_t value) {
    if (count_bytes_ == 4) return append(text_, static_cast<std::uint32_t>(value), big_);
    append(text_, static_cast<std::uint64_t>(value), big_);
  }

  void write_4() {
    const std::size_t n = mesh_.points.size(), first = 3;
    text_ += "$Entities\n";
    for (int k = 0; k < 4; ++k) count(0);
    text_ += "\n$EndEntities\n$Nodes\n";
    count(2), count(n), count(1), count(99);
    for (const auto& [from, end, parametric] : {std::tuple(std::size_t{0}, first, 1), std::tuple(first, n, 0)}) {
      put(2), put(1), put(parametric), count(end - from);
      for (std::size_t i = from; i < end; ++i) count(static_cast<std::size_t>(mesh_.numbers[i]));
      for (std::size_t i = from; i < end; ++i) {
        for (const double x : mesh_.points[i]) put(x);
        for (int k = 0; k < 2 * parametric; ++k) put(0.5);
      }
    }
    text_ += "\n$EndNodes\n$Elements\n";
    std::size_t blocks = 0, number = 0;
    each_block(mesh_, [&](std::size_t, std::size_t) { ++blocks; });
    count(blocks), count(mesh_.elements.size()), count(1), count(mesh_.elements.size());
    each_block(mesh_, [&](std::size_t from, std::size_t end) {
      put(2), put(1), put(mesh_.elements[from].first), count(end - from);
      for (std::size_t e = from; e < end; ++e) {
        count(++number);
        for (const int corner : mesh_.elements[e].second) count(static_cast<std::size_t>(corner));
      }
    });
    text_ += "\n$EndElements\n";
  }

  void write_2() {
    text_ += "$Nodes\n" + std::to_string(mesh_.points.size()) + "\n";
    for (std::size_t i = 0; i < mesh_.points.size(); ++i) {
      put(mesh_.numbers[i]);
      for (const double x : mesh_.points[i]) put(x);
    }
    text_ += "\n$EndNodes\n$Elements\n" + std::to_string(mesh_.elements.size()) + "\n";
    int number = 0;
    each_block(mesh_, [&](std::size_t from, std::size_t end) {
      put(mesh_.elements[from].first), put(static_cast<int>(end - from)), put(2);
      for (std::size_t e = from; e < end; ++e) {
        put(++number), put(1), put(7);
        for (const int corner : mesh_.elements[e].second) put(corner);
      }
    });
    text_ += "\n$EndElements\n";
  }

  GmshMesh mesh_;
  bool big_;
  int count_bytes_;
  std::string text_;
};

/// The same mesh as text of version 2.2.
std::string gmsh_text() {
  const GmshMesh mesh;
  std::ostringstream text;
  text.precision(17);
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << mesh.points.size() << "\n";
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    text << mesh.numbers[i] << " " << mesh.points[i][0] << " " << mesh.points[i][1] << " " << mesh.points[i][2] << "\n";
  text << "$EndNodes\n$Elements\n" << mesh.elements.size() << "\n";
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    text << e + 1 << " " << mesh.elements[e].first << " 2 1 7";
    for (const int corner : mesh.elements[e].second) text << " " << corner;
    text << "\n";
  }
  return text.str() + "$EndElements\n";
}

std::vector<std::string> gmsh_forms() {
  std::vector<std::string> all;
  for (const bool big : {false, true}) {
    for (const int bytes : {4, 8}) all.push_back(GmshBytes(big, bytes).text());
    all.push_back(GmshBytes(big, 8, 2).text());
  }
  return all;
}

class BinaryGmsh : public MeshFiles {};

TEST_F(BinaryGmsh, IsTheMeshOfItsTextToTheBit) {
  const Mesh expected = read_mesh(file("text.msh", gmsh_text()));
  EXPECT_EQ(expected.tetrahedra.size(), 2u);
  for (const std::string& bytes : gmsh_forms()) {
    const Mesh mesh = read_mesh(file("bytes.msh", bytes));
    EXPECT_EQ(mesh.points, expected.points);
    EXPECT_EQ(mesh.faces, expected.faces);
    EXPECT_EQ(mesh.tetrahedra, expected.tetrahedra);
  }
  const Mesh raw = read_gmsh("a.msh", gmsh_forms()[1]);  // before tetrahedra get their surface as faces
  EXPECT_EQ(raw.faces, (std::vector<Quad>{{1, 5, 6, 4}, {5, 6, 4, -1}, {1, 5, 4, -1}}));
}

// A damaged file gives a mesh whose corners exist, or an error of one line that names the file and the byte.
void expect_read_or_refused(const std::string& bytes, const std::string& what) {
  try {
    const Mesh mesh = read_gmsh("a.msh", bytes);
    const int points = static_cast<int>(mesh.points.size());
    for (const Quad& face : mesh.faces)
      for (const int corner : face) ASSERT_TRUE(corner >= -1 && corner < points) << what;
    for (const Tetrahedron& t : mesh.tetrahedra)
      for (const int corner : t) ASSERT_TRUE(corner >= 0 && corner < points) << what;
  } catch (const InputError& error) {
    const std::string said = error.what();
    ASSERT_TRUE(said.starts_with("a.msh: line ") || said.starts_with("a.msh: byte ")) << what << ": " << said;
  }
}

TEST_F(BinaryGmsh, IsReadOrRefusedWhereverItIsCutOrABitFlips) {
  for (const std::string& whole : gmsh_forms()) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::string cut = whole.substr(0, size);
      expect_read_or_refused(cut, "cut at " + std::to_string(size));
      if (size + 2 < whole.size()) {
        EXPECT_NE(refusal([&] { read_gmsh("a.msh", cut); }), "") << size;
      }
    }
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      std::string flipped = whole;
      flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
      expect_read_or_refused(flipped, "bit " + std::to_string(bit));
    }
  }
}

TEST_F(BinaryGmsh, IsReadOrRefusedWithAnyBytesInIt) {
  std::mt19937 random(7);
  const std::vector<std::string> forms = gmsh_forms();
  for (int trial = 0; trial < 20000; ++trial) {
    std::string bytes = forms[random() % forms.size()];
    for (int k = 0, most = 1 + static_cast<int>(random() % 6); k < most; ++k) {
      const std::size_t at = random() % bytes.size(), length = 1 + random() % 8;
      for (std::size_t i = at; i < std::min(at + length, bytes.size()); ++i)
        bytes[i] = static_cast<char>(random() % 3 == 0 ? 0xff : random());
    }
    expect_read_or_refused(bytes, "trial " + std::to_string(trial));
  }
}

/// Replaces the 64-bit number that follows `mark` and that many further bytes.
std::string with_count(std::string bytes, const std::string& mark, std::size_t behind, std::uint64_t value) {
  std::string raw;
  append(raw, value);
  return bytes.replace(bytes.find(mark) + mark.size() + behind, 8, raw);
}

TEST_F(BinaryGmsh, IsRefusedWithTheByteAndWhatIsAllowedThere) {
  const std::string good = GmshBytes(false, 8).text();
  const auto byte_of = [&](const std::string& mark, std::size_t behind) {
    return "a.msh: byte " + std::to_string(good.find(mark) + mark.size() + behind) + ": ";
  };
  const auto said = [](const std::string& bytes) { return refusal([&] { read_gmsh("a.msh", bytes); }); };
  const std::string nodes = "$Nodes\n", elements = "$Elements\n";
  const std::size_t left = good.size() - good.find(nodes) - nodes.size();
  // A count that would take 2^46 bytes is compared with the file's size before anything is allocated.
  EXPECT_EQ(said(with_count(good, nodes, 8, std::uint64_t{1} << 46)),
            byte_of(nodes, 8) + "found 70368744177664 as the number of nodes; allowed: 0 to " +
                std::to_string((left - 16) / 16) + ", as many as the rest of the file can hold");
  EXPECT_EQ(said(with_count(good, nodes, 0, ~std::uint64_t{0})),
            byte_of(nodes, 0) + "found 18446744073709551615 as the number of blocks; allowed: a number below 2^63");
  EXPECT_NE(said(with_count(good, nodes, 8, 6)).find("found 7 nodes in all blocks; allowed: 6, as announced"),
            std::string::npos);
  const std::size_t last = good.find("\n$EndElements") - 8;
  EXPECT_EQ(said(good.substr(0, last + 4)), "a.msh: byte " + std::to_string(last) +
                                                ": found the end of the file after 4 bytes; allowed: a corner of "
                                                "element 2 of 2");
  EXPECT_EQ(said(with_count(good, elements, 32 + 12 + 8 + 8, 11)),
            byte_of(elements, 32 + 12 + 8 + 8) + "found node 11; allowed: one of $Nodes");
  EXPECT_EQ(said(with_count(good, nodes, 32 + 12 + 8 + 3 * 8, 0x7ff8000000000000)),
            byte_of(nodes, 32 + 12 + 8 + 3 * 8) + "found a NaN or infinite x; allowed: a finite number");
  std::string no_order = good;
  no_order[good.find("8\n") + 2] = 2;
  EXPECT_EQ(said(no_order), byte_of("1 8\n", 0) +
                                "found four bytes that are not the integer 1 in either byte order; allowed: the "
                                "integer 1, which gives the byte order");
  std::string type = good;
  type.replace(type.find("4.1 1 8"), 7, "4.1 2 8");
  EXPECT_EQ(said(type), "a.msh: line 2, column 5: found 2 as the file type; allowed: 0 (ASCII) or 1 (binary)");
  type.replace(type.find("4.1 2 8"), 7, "4.1 1 7");
  EXPECT_EQ(said(type), "a.msh: line 2, column 7: found numbers of 7 bytes; allowed: 8 or 4");
}

}  // namespace
}  // namespace malha
