// SPDX-License-Identifier: Apache-2.0
// Takes the place of report.cpp in a build without MALHA_JSON.
#include "host/report/report.h"
#include "malha/error.h"

namespace malha {

std::string measures_json(const Model&, const Solver&, const RunTimes&) {
  refuse("report", "", "measures as JSON, and this malha was built with MALHA_JSON=OFF", "Simulation::measure()");
}

std::string report_json(const std::string&, const std::vector<std::string>&, const Model&, const Solver&, int,
                        const RunTimes&, const std::string&) {
  refuse("report", "", "a report, and this malha was built with MALHA_JSON=OFF", "Simulation::measure()");
}

}  // namespace malha
