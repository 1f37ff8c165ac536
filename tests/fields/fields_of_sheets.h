// SPDX-License-Identifier: Apache-2.0
// A fixture for tests of fields: irregular sheets.
#pragma once
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/mesh/irregular_mesh.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {

/// An irregular sheet of 1 m x 1 m, read from a file.
class FieldsOfSheets : public testing::Test {
 protected:
  Scene sheet(int cells, std::vector<ConstraintSpec> constraints, std::vector<Pin> pins = {}) {
    BodySpec body;
    body.name = "sheet", body.mass = 0.3;
    body.shape = MeshFile{folder_.write("sheet.obj", irregular_obj(1, 1, cells, cells, 0.2, 5)), {}};
    body.constraints = std::move(constraints), body.pins = std::move(pins);
    return scene_of({body}, kEarth, 0.02, 5, Precision::Float);
  }
  TemporaryFolder folder_;
};

}  // namespace malha
