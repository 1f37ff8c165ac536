#include "tools/study/accuracy.h"
#include "tools/study/parsimony.h"
#include "tools/study/published.h"
#include "tools/study/stability.h"
#include "tools/study/study.h"

namespace malha::study {

const std::vector<Study>& studies() {
  static const std::vector<Study> all{
      {"accuracy", "Error against cost of every method, beside explicit and implicit integrators", run_accuracy},
      {"stability", "Where each method fails, how, and what guards the user", run_stability},
      {"parsimony", "What each feature adds to a scene: time, memory, kernels launched", run_parsimony},
      {"published", "Cases that papers print, repeated with their own parameters, ours beside theirs", run_published},
  };
  return all;
}

}  // namespace malha::study
