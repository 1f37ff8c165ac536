// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/filter.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "malha/error.h"
#include "malha/text.h"
#include "tools/bench/facts.h"
#include "tools/bench/filter/chart.h"
#include "tools/bench/filter/filter_case.h"
#include "tools/bench/filter/measure.h"
#include "tools/bench/filter/step.h"
#include "tools/bench/filter/table.h"
#include "tools/bench/machine.h"
#include "tools/bench/output.h"
#include "tools/bench/peers/openblas.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

bool is_selected(const FilterOptions& options, const std::string& kernel) {
  if (options.kernels.empty()) return kernel != "step" || options.n.empty();
  return std::find(options.kernels.begin(), options.kernels.end(), kernel) != options.kernels.end();
}

Json facts_of(const std::vector<int>& threads, const RunsOn& on) {
  Json facts = machine_facts(threads, on);
  if (!openblas_version().empty()) facts["openblas_version"] = openblas_version();
  facts["cache_bytes"] = cache_bytes();
  facts["read_bytes"] = kMemoryBytes;
  facts["read_gb_per_s"] = bandwidths(threads, read_gb_per_s);
  return facts;
}

std::string introduction(const FilterOptions& options, const Json& facts) {
  return formatted(
             "The filter of a hanging cloth (springs of 1e4 N/m, dt = 1/60 s) times three right-hand sides: %d x %g s "
             "a line,\nthose on as many threads in turns; medians. of read, x triad: relative to reading, and to a "
             "triad, of as many bytes.\nerror, elastic: relative errors for noise and for spring forces. / sgemm ...: "
             "times "
             "as fast as OpenBLAS.\n",
             options.repeats, options.seconds) +
         machine_lines(facts, openblas_version()) + bandwidth_line(facts, "read_gb_per_s", "reading from memory");
}

int step_cap(const FilterOptions& options, bool dense) {
  const int all = dense ? 158 : 1000;  // about kMostDense unknowns; a million particles
  return options.n.empty() ? all : std::min(all, *std::max_element(options.n.begin(), options.n.end()));
}

/// Runs size after size, and writes all results after each.
class Bench {
 public:
  explicit Bench(const FilterOptions& options)
      : options_(options), out_("filter", options), threads_(thread_counts(options)) {
    out_.show_progress("measuring the machine", 0);
    out_.facts = facts_of(threads_, options.on);
    out_.print(introduction(options, out_.facts));
  }

  void products() {
    FilterTiming timing{options_, is_selected(options_, "dense"), is_selected(options_, "sparse")};
    timing.threads = threads_;
    if (!timing.dense && !timing.sparse) return;
    const std::vector<int> sides =
        options_.n.empty() ? std::vector{17, 24, 32, 46, 71, 100, 141, 316, 1000} : sorted(options_.n);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      const FilterRows now = measure_filters(sides[k], timing, [&](const std::string& what, double part) {
        out_.show_progress("N = " + std::to_string(sides[k]) + ", " + what,
                           (static_cast<double>(k) + part) / static_cast<double>(sides.size()));
      });
      out_.print(filter_table(now.rows, now.left_out));
      rows_.insert(rows_.end(), now.rows.begin(), now.rows.end());
      write();
    }
    out_.print(crossover(rows_) + promise_lines(rows_, out_.facts["cache_bytes"].get<double>()));
    write();
  }

  void steps() {
    if (!is_selected(options_, "step")) return;
    std::vector<FilterRow> found;
    double searched = 0;
    for (const FilterKind filter : {FilterKind::Dense, FilterKind::Sparse})
      for (const int threads : threads_) {
        const StepSearch search{options_.on, filter, threads, step_cap(options_, filter == FilterKind::Dense),
                                options_.repeats * options_.seconds};
        const auto row = find_real_time_limit(search, [&](const std::string& what) {
          out_.show_progress(what + " on " + counted(threads, "thread"),
                             searched / (2.0 * static_cast<double>(threads_.size())));
        });
        if (row) found.push_back(*row);
        ++searched;
      }
    out_.print(step_table(found));
    rows_.insert(rows_.end(), found.begin(), found.end());
    write();
  }

  void finish() const {
    out_.list();
    out_.list_chart(no_chart_);
  }

 private:
  /// Writes the rows so far, so that they are not lost if the next size fails.
  void write() {
    out_.write(to_json(rows_));
    if (!rows_.empty() && !rows_.back().is_step()) no_chart_ = draw_filter_chart(rows_, out_.folder());
  }

  const FilterOptions& options_;
  Output out_;
  std::vector<int> threads_;
  std::vector<FilterRow> rows_;
  std::string no_chart_ = "there are no products";
};

}  // namespace

void run_filter(const FilterOptions& options) {
  if (options.on.is_device() && (is_selected(options, "dense") || is_selected(options, "sparse")))
    refuse("malha bench filter", "--backend", "\"cuda\" with single products", "--kernel step, which runs on devices");
  Bench bench(options);
  bench.products();
  bench.steps();
  bench.finish();
}

}  // namespace malha::bench
