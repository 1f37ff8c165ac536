#include "tools/study/accuracy.h"
#include "tools/study/study.h"

namespace malha::study {

const std::vector<Study>& studies() {
  static const std::vector<Study> all{
      {"accuracy", "Error against cost of every method, beside explicit and implicit integrators", run_accuracy},
  };
  return all;
}

}  // namespace malha::study
