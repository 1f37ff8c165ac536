// SPDX-License-Identifier: Apache-2.0
// Cases of the study "published", one per paper. Each adds rows, and a section with printed results beside malha's.
#pragma once
#include "malha/scene.h"
#include "tools/study/study.h"

namespace malha::study {

struct PublishedPart {
  int (*cells)(bool quick);  // number of cells
  void (*add)(Cells& cells, Findings& findings);
};

extern const PublishedPart kSpringOf2016;  // XPBD: oscillator
extern const PublishedPart kChainOf2016;   // XPBD: chain
extern const PublishedPart kWeightOf2019;  // Small Steps: chain with a weight
extern const PublishedPart kStrandOf2024;  // Vertex Block Descent: strand
extern const PublishedPart kSheetsOf2008;  // a thesis: frame rates
extern const PublishedPart kClothOf2006;   // PBD: self-colliding cloth

/// A scene of one body by PBD in double, in gravity along -y.
Scene published_scene(const BodySpec& body, double dt, int substeps, int iterations, double gravity = 9.81);

/// A percentage of three digits: "6 %" for 0.0600001.
std::string percent(double part);

}  // namespace malha::study
