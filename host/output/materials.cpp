// SPDX-License-Identifier: Apache-2.0
// Wavefront MTL: "newmtl NAME", then a line for each property. Lines of pictures have options before the path.
#include "host/output/materials.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "host/base/file.h"
#include "host/mesh/io/mesh_io.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// A line of a material: a keyword and what follows.
struct MtlLine {
  std::string keyword, rest;
};

struct MtlMaterial {
  fs::path folder;  // of the file
  std::vector<MtlLine> lines;
};

std::string trimmed(const std::string& text) {
  constexpr char blanks[] = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

MtlLine split_keyword(const std::string& line) {
  const std::string text = trimmed(line);
  const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
  return {text.substr(0, end), trimmed(text.substr(end))};
}

/// The files of materials that an OBJ file names: one whole line is a file, or each of its words.
std::vector<fs::path> files_of(const FrameMaterial& material) {
  const fs::path folder = fs::path(material.file).parent_path();
  std::vector<fs::path> files;
  for (const std::string& line : material.libraries) {
    if (fs::exists(folder / line)) {
      files.push_back(folder / line);
      continue;
    }
    std::istringstream words(line);
    for (std::string word; words >> word;)
      if (fs::exists(folder / word)) files.push_back(folder / word);
  }
  return files;
}

std::optional<MtlMaterial> find_mtl(const FrameMaterial& material) {
  for (const fs::path& path : files_of(material)) {
    std::istringstream text(read_whole(path));
    std::optional<MtlMaterial> found;
    for (std::string line; std::getline(text, line);) {
      MtlLine one = split_keyword(line);
      if (one.keyword == "newmtl") {
        if (found) break;
        if (one.rest == material.in_file) found = MtlMaterial{path.parent_path(), {}};
      } else if (found && !one.keyword.empty() && one.keyword[0] != '#') {
        found->lines.push_back(std::move(one));
      }
    }
    if (found) return found;
  }
  return {};
}

bool names_picture(const std::string& keyword) {
  return keyword.starts_with("map_") || keyword == "bump" || keyword == "disp" || keyword == "decal" ||
         keyword == "refl" || keyword == "norm";
}

/// Returns where the path begins that follows the options; those of three numbers may have fewer.
std::size_t begin_of_path(const std::string& rest) {
  std::istringstream words(rest);
  const auto here = [&] { return words.eof() ? rest.size() : static_cast<std::size_t>(words.tellg()); };
  std::size_t begin = 0;
  for (std::string word; words >> word && word[0] == '-' && word.size() > 1;) {
    const bool three = word == "-o" || word == "-s" || word == "-t";
    for (int left = three ? 3 : word == "-mm" ? 2 : 1; left > 0; --left) {
      begin = here();
      if (!(words >> word)) return rest.size();
      double number = 0;
      const bool is_number = std::from_chars(word.data(), word.data() + word.size(), number).ec == std::errc{};
      if (three && !is_number) {  // the path, or the next option
        words.seekg(static_cast<std::streamoff>(begin));
        break;
      }
      begin = here();
    }
  }
  return std::min(rest.find_first_not_of(" \t", begin), rest.size());
}

std::array<double, 3> three_numbers(const std::string& text, std::array<double, 3> otherwise) {
  std::istringstream words(text);
  std::array<double, 3> x{};
  if (!(words >> x[0])) return otherwise;
  if (!(words >> x[1] >> x[2])) x[1] = x[2] = x[0];
  return x;
}

}  // namespace

std::string picture_format(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return "image/png";
  return bytes.starts_with("\xff\xd8") ? "image/jpeg" : "";
}

MaterialLook look_of(const FrameMaterial& material) {
  if (is_gltf_file(material.file)) return look_in_gltf(material).value_or(MaterialLook{});
  MaterialLook look;
  const std::optional<MtlMaterial> found = find_mtl(material);
  if (!found) return look;
  for (const auto& [keyword, rest] : found->lines) {
    if (keyword == "Kd") look.colour = three_numbers(rest, look.colour);
    if (keyword == "d") look.opacity = three_numbers(rest, {1, 1, 1})[0];
    if (keyword == "Tr") look.opacity = 1 - three_numbers(rest, {0, 0, 0})[0];
    if (keyword == "map_Kd")
      look.picture = (found->folder / rest.substr(begin_of_path(rest))).lexically_normal().string();
  }
  for (double& x : look.colour) x = std::clamp(x, 0.0, 1.0);
  look.opacity = std::clamp(look.opacity, 0.0, 1.0);
  return look;
}

void write_mtl(const fs::path& folder, const FrameTopology& topology) {
  if (topology.materials.empty()) return;
  std::string text;
  for (const FrameMaterial& material : topology.materials) {
    text += "newmtl " + material.name + "\n";
    const std::optional<MtlMaterial> found = find_mtl(material);
    if (!found) {
      const MaterialLook look = look_of(material);
      std::ostringstream lines;
      lines << "Kd " << look.colour[0] << " " << look.colour[1] << " " << look.colour[2] << "\nd " << look.opacity
            << "\n";
      text += lines.str();
      continue;
    }
    for (const auto& [keyword, rest] : found->lines) {
      text += keyword + " ";
      const std::size_t path = names_picture(keyword) ? begin_of_path(rest) : rest.size();
      text += rest.substr(0, path);
      if (path < rest.size()) {
        const fs::path whole = fs::absolute(found->folder / rest.substr(path)).lexically_normal();
        text += whole.lexically_relative(fs::absolute(folder).lexically_normal()).generic_string();
      }
      text += "\n";
    }
  }
  write_whole(folder / kMaterialFile, text);
}

}  // namespace malha
