// SPDX-License-Identifier: Apache-2.0
#include "host/base/spelling_suggestion.h"

#include <algorithm>
#include <cctype>

namespace malha {

std::string lower(std::string word) {
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word;
}

namespace {

/// Returns the Damerau-Levenshtein distance, by optimal string alignment.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

/// A name of malha, and the words for it that the field or other programs use, with blanks between them.
struct Meaning {
  const char *here, *words, *remark = "";  // the remark is for the message
};
constexpr Meaning kMeanings[] = {
    // constraints
    {"distance", "spring springs stretch stretching structural length stick edge edges rod rope"},
    {"distance", "shear", " with \"elements\": [\"shear\"]"},
    {"membrane", "cloth shell fabric", " Or 'distance', and 'bending' for folds"},
    {"membrane", "triangle strain area"},
    {"distance_limit", "strain_limit"},
    {"bending", "fold bend hinge dihedral"},
    {"isometric_bending", "quadratic_bending"},
    {"neo_hookean", "fem solid elastic hyperelastic corotated corotational stvk softbody soft_body tetrahedra arap"},
    {"neo_hookean", "shape_matching"},
    {"long_range", "tether tethers lra inextensible"},
    {"pressure", "inflate inflation balloon gas"},
    {"volume", "incompressible volume_preservation volume_conservation"},
    // solvers
    {"pbd", "xpbd", " A constraint's \"compliance\" makes it XPBD"},
    {"pbd", "fem", " \"neo_hookean\" and \"membrane\" are elements of it"},
    {"pbd", "vbd position_based_dynamics"},
    {"desbrun", "implicit backward_euler mass_spring"},
    {"desbrun", "projective_dynamics", " With \"refinement_iterations\""},
    // keys
    {"dt", "time_step timestep step"},
    {"environment", "colliders collision obstacles objects"},
    {"pins", "fixed anchors"},
    {"transform", "position"},
    {"translate", "translation offset"},
    {"spin", "angular_velocity"},
    {"mass", "weight"},
    {"duration", "end end_time"},
    {"eye", "from position"},
    {"target", "look_at to"},
    {"friction", "mu"},
    {"restitution", "bounciness"},
    {"young_modulus", "youngs_modulus"},
    {"points", "vertices"},
    {"faces", "triangles"},
    {"thickness", "margin"},
    {"mesh", "file"},
    {"grid", "plane"},
    {"sphere", "icosphere ball"},
    {"box", "cube"},
    // options
    {"--every", "--fps --frames", " A frame every N steps"},
    {"--out", "--output"},
    {"--seconds", "--duration --time"},
};

/// Keys of scenes that had another name before release 0.1.
struct Renamed {
  const char *before, *now;
};
constexpr Renamed kRenamed[] = {{"stiffness_of", "stiffness_basis"},
                                {"levels_every", "levels_interval"},
                                {"until", "release_time"},
                                {"refine", "refinement_iterations"},
                                {"filtered", "filter_external_forces"},
                                {"listed", "mesh_data"},
                                {"cloud", "lattice"},
                                {"megabytes", "max_megabytes"},
                                {"on", "elements"},
                                {"inside", "bounds"}};

const Meaning* meaning_of(const std::string& word, const std::vector<std::string>& allowed) {
  std::string plain = lower(word);
  for (std::size_t i = 2; i < plain.size(); ++i)  // an option keeps the dashes that it begins with
    if (plain[i] == '-' || plain[i] == ' ') plain[i] = '_';
  for (const Meaning& meaning : kMeanings)
    if ((" " + std::string(meaning.words) + " ").find(" " + plain + " ") != std::string::npos &&
        std::ranges::find(allowed, meaning.here) != allowed.end())
      return &meaning;
  return nullptr;
}

}  // namespace

std::string near_miss(const std::string& word, const std::vector<std::string>& allowed) {
  constexpr std::size_t longest = 64;  // no key is as long, so that no longer word can be close to one
  const auto letters = [](const std::string& of) { return of.substr(std::min(of.find_first_not_of('-'), of.size())); };
  const std::size_t size = letters(word).size();  // the dashes of options do not count
  if (size == 0 || size > longest) return "";
  std::string best;
  std::size_t best_distance = size <= 4 ? 2 : size <= 8 ? 3 : 4;  // the smallest distance that is too large
  for (const std::string& candidate : allowed) {
    const std::size_t distance = edit_distance(lower(word), lower(candidate));
    if (distance >= best_distance || distance >= letters(candidate).size()) continue;
    best_distance = distance;
    best = candidate;
  }
  return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& allowed) {
  for (const Renamed& key : kRenamed)
    if (word == key.before && std::ranges::find(allowed, key.now) != allowed.end())
      return std::string(" (its name is '") + key.now + "' now)";
  if (const Meaning* meaning = meaning_of(word, allowed))
    return std::string(" (did you mean '") + meaning->here + "'?" + meaning->remark + ")";
  const std::string near = near_miss(word, allowed);
  return near.empty() ? "" : " (did you mean '" + near + "'?)";
}

std::string join(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

}  // namespace malha
