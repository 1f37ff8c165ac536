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
      {"accuracy", "Error over cost of every method, with explicit and implicit integrators for comparison",
       run_accuracy, true},
      {"published", "Published results, repeated with the papers' parameters, beside malha's", run_published},
      {"stability", "Settings with which each method fails, how it fails, and remedies", run_stability},
      {"scaling", "Speed-up by more threads, pass by pass, on the same body and on one that grows", run_scaling, true},
      {"parsimony", "Time, memory and kernel launches that each feature adds to a scene", run_parsimony},
      {"size", "Time, memory and set-up per particle, and errors, from 289 particles to 4 million", run_size},
      {"validation", "malha against experiments, closed forms and boundary value problems of the literature", nullptr},
  };
  return all;
}

}  // namespace malha::study
