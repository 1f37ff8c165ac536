// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/projection/projection.h"

#include <map>
#include <nlohmann/json.hpp>

#include "host/base/memory_size.h"
#include "malha/error.h"
#include "tools/bench/facts.h"
#include "tools/bench/machine.h"
#include "tools/bench/output.h"
#include "tools/bench/peers/bullet.h"
#include "tools/bench/projection/chart.h"
#include "tools/bench/projection/measure.h"
#include "tools/bench/projection/table.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

struct PlannedCase {
  bool grid;
  int n;
};

std::vector<PlannedCase> plan(const ProjectionOptions& options) {
  std::vector<PlannedCase> cases;
  const std::vector<int> given = sorted(options.n);
  const bool irregular = options.only == "irregular" || (options.only.empty() && options.n.empty());
  if (options.only != "irregular")
    for (const int n : given.empty() ? std::vector{17, 46, 100, 316, 1000} : given) cases.push_back({true, n});
  if (irregular)
    for (const int n : given.empty() ? std::vector{100'000} : given) cases.push_back({false, n});
  return cases;
}

/// Facts about the machine, with Bullet's version.
Json facts_of(const MeasuringOptions& timing, double root_ns) {
  Json facts = machine_facts(timing.threads, timing.on);
  if (!bullet_version().empty()) facts["bullet_version"] = bullet_version();
  facts["root_and_quotient_ns"] = root_ns;
  return facts;
}

std::string introduction(const ProjectionOptions& options, const Json& facts) {
  return formatted(
             "A hanging cloth in float, dt = 1/60 s: %d steps of warm-up, then %d x %g s a line, in turns; "
             "medians.\nStrain and state are those after the warm-up. The floor is the larger of the times of memory "
             "(triad at "
             "that size)\nand of arithmetic (a square root and a division, %.3f ns on 1 thread).\n",
             kWarmUpSteps, options.repeats, options.seconds, facts["root_and_quotient_ns"].get<double>()) +
         machine_lines(facts, bullet_version().empty() ? "" : "Bullet " + bullet_version());
}

/// Refuses cases whose simulations, which are in memory together, need more than is free.
void check_memory(const std::vector<PlannedCase>& cases, const std::vector<int>& threads) {
  const auto free = static_cast<double>(available_memory()), lines = static_cast<double>(lines_of_malha(threads));
  for (const PlannedCase& planned : cases) {
    const double particles = planned.grid ? double(planned.n) * planned.n : planned.n;
    const double needed = particles * (lines * kLineBytes + kSetUpBytes);
    if (needed <= free) continue;
    char needs[160], has[80];
    std::snprintf(needs, sizeof needs, "%d, which takes about %.3g GiB: %g lines of %.3g particles", planned.n,
                  needed / (1 << 30), lines, particles);
    std::snprintf(has, sizeof has, "what fits into the %.3g GiB that are free; fewer threads have fewer lines",
                  free / (1 << 30));
    refuse("malha bench projection", "--n", needs, has);
  }
}

}  // namespace

void run_projection(const ProjectionOptions& options) {
  MeasuringOptions timing = options;
  timing.threads = thread_counts(options);
  const std::vector<PlannedCase> cases = plan(options);
  check_memory(cases, timing.threads);
  Output out("projection", options);
  out.show_progress("measuring the machine", 0);
  const double root_ns = root_and_quotient_ns();
  out.facts = facts_of(timing, root_ns);
  out.print(introduction(options, out.facts));

  std::vector<Row> all;
  std::string no_chart;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    Case which = cases[k].grid ? grid_case(cases[k].n) : irregular_case(cases[k].n);
    const std::string name = which.name + " " + std::to_string(which.n) + ", ";
    const std::string left_out = bullet_left_out(which);
    std::vector<Row> rows = measure(std::move(which), timing, [&](const std::string& what, double part) {
      out.show_progress(name + what, (static_cast<double>(k) + part) / static_cast<double>(cases.size()));
    });
    std::map<int, double> triad;  // by threads
    for (Row& row : rows) {
      if (!triad.contains(row.threads))
        triad[row.threads] =
            memory_gb_per_s(out.facts, row.on_device(), static_cast<std::size_t>(working_set_bytes(row)), row.threads);
      set_floor(row, triad[row.threads], root_ns, cores());
    }
    out.print(table(rows, left_out));
    all.insert(all.end(), rows.begin(), rows.end());
    out.write(to_json(all));  // after each case, so that it is not lost if the next one fails
    no_chart = draw_chart(all, out.folder());
  }
  out.list();
  out.list_chart(no_chart);
}

}  // namespace malha::bench
