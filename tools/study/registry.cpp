// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/accuracy.h"
#include "tools/study/parsimony/parsimony.h"
#include "tools/study/published/published.h"
#include "tools/study/scaling/scaling.h"
#include "tools/study/size/size.h"
#include "tools/study/stability/stability.h"
#include "tools/study/study.h"

namespace malha::study {

const std::vector<Study>& studies() {
  static const std::vector<Study> all{
      {"accuracy", "Error against cost of every method, beside explicit and implicit integrators", run_accuracy, true},
      {"published", "Cases that papers print, repeated with their own parameters, ours beside theirs", run_published},
      {"stability", "Where each method fails, how, and what guards the user", run_stability},
      {"scaling", "How much faster more threads are, pass by pass, on the same body and on one that grows", run_scaling,
       true},
      {"parsimony", "What each feature adds to a scene: time, memory, kernels launched", run_parsimony},
      {"size",
       "What a particle costs in time, memory and set-up, and how far off it is, from 289 particles to 4 million",
       run_size},
  };
  return all;
}

}  // namespace malha::study
