// SPDX-License-Identifier: Apache-2.0
// The quick version of a study, which runs once for all of its tests.
#pragma once
#include <atomic>

#include "tests/support.h"
#include "tools/study/study.h"

namespace malha::study {

template <Findings (*run)(Cells&)>
const Findings& quick_findings() {
  static const std::atomic<bool> no_stop{false};
  static const Findings findings = [] {
    const TemporaryFolder folder;
    Cells cells(folder / "cells.jsonl", {}, true, no_stop);
    return run(cells);
  }();
  return findings;
}

}  // namespace malha::study
