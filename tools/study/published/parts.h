// SPDX-License-Identifier: Apache-2.0
// The cases of the study "published", a file each. Each has rows of its own and a section with theirs beside ours.
#pragma once
#include "malha/scene.h"
#include "tools/study/study.h"

namespace malha::study {

struct PublishedPart {
  int (*cells)(bool quick);  // how many it makes
  void (*add)(Cells& cells, Findings& findings);
};

extern const PublishedPart kSpringOf2016;  // XPBD's oscillator
extern const PublishedPart kChainOf2016;   // and its chain
extern const PublishedPart kWeightOf2019;  // Small Steps' chain with a weight
extern const PublishedPart kStrandOf2024;  // VBD's strand
extern const PublishedPart kSheetsOf2008;  // the thesis' frame rates
extern const PublishedPart kClothOf2006;   // PBD's self-colliding cloth

/// A scene of one body by PBD in double, in gravity along -y.
Scene published_scene(const BodySpec& body, double dt, int substeps, int iterations, double gravity = 9.81);

/// "6 %" of 0.0600001: three digits.
std::string percent(double part);

}  // namespace malha::study
