// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/projection/table.h"

#include "malha/text.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

std::string heading(const std::vector<Row>& rows) {
  const Row& row = rows.front();
  std::string text =
      formatted("\n%s, %s = %d: %lld particles, %lld constraints, %.3g MiB; triad at that size", row.case_name.c_str(),
                row.case_name == "grid" ? "N" : "n", row.n, static_cast<long long>(row.particles),
                static_cast<long long>(row.constraints), row.working_set_bytes / (1 << 20));
  const char* separator = " ";
  for (const Row& r : rows) {
    if (r.library != "malha" || !(r.schedule == rows.front().schedule)) continue;
    text += separator + formatted("%.0f GB/s on ", r.triad_gb_per_s) + executor_of(r);
    separator = ", ";
  }
  return text + "\n";
}

std::string line(const Row& row) {
  const std::string spread = formatted("(%.3g .. %.3g)", row.ns_min(), row.ns_max());
  return formatted("  %-8s %-11s %7d %9.3f %-18s %10.4g %9.1f %12.5f %12.5f  %s\n",
                   (row.on_device() ? row.backend : row.library).c_str(), row.schedule.name().c_str(), row.threads,
                   row.ns_per_projection(), spread.c_str(), row.step_ms(), row.ns_per_projection() / row.floor_ns(),
                   row.strain.rms, row.strain.max, hex(row.state_hash).c_str());
}

double value_of(const NamedNumbers& parts, const std::string& name) {
  for (const auto& [owner, number] : parts)
    if (owner == name) return number;
  return 0;
}

std::string set_up_of_levels(const Row& row, const Row& plain) {
  return formatted("  levels on %s: set-up %.3g s instead of %.3g, %.3g B a particle\n", executor_of(row).c_str(),
                   value_of(row.setup_seconds, "total"), value_of(plain.setup_seconds, "total"),
                   value_of(row.memory, "levels") / static_cast<double>(row.particles));
}

/// Times of the parts of set-up, and memory, for the first schedule on the largest number of threads.
std::string setup_lines(const std::vector<Row>& rows) {
  const Row* shown = nullptr;
  for (const Row& row : rows)
    if (row.library == "malha" && row.schedule == rows.front().schedule) shown = &row;
  if (shown == nullptr) return "";
  std::string text = "  set-up on " + executor_of(*shown) + ":";
  for (const auto& [part, seconds] : shown->setup_seconds)
    if (seconds > 0) text += formatted(" %s %.3g s,", part.c_str(), seconds);
  text.back() = '\n';
  text += "  memory:";
  for (const auto& [owner, bytes] : shown->memory) {
    const bool of_constraints = owner == "constraints";
    const auto count = static_cast<double>(of_constraints ? shown->constraints : shown->particles);
    if (bytes > 0)
      text += formatted(" %s %.3g B a %s,", owner.c_str(), bytes / count, of_constraints ? "constraint" : "particle");
  }
  text.back() = '\n';
  return text;
}

}  // namespace

std::string table(const std::vector<Row>& rows, const std::string& bullet_left_out) {
  std::string text = heading(rows);
  text += formatted("  %-8s %-11s %7s %9s %-18s %10s %9s %12s %12s  %s\n", "library", "schedule", "threads", "ns/proj.",
                    "(min .. max)", "step ms", "x floor", "strain rms", "strain max", "state hash");
  for (const Row& row : rows) text += line(row);
  for (const Row& row : rows) {
    const Row* one = on_one_thread(rows, row);
    if (one != nullptr && one != &row)
      text += formatted("  %s on %s: %.2f x as fast as on 1\n", row.schedule.name().c_str(), executor_of(row).c_str(),
                        times_as_fast(row, *one));
  }
  for (const Row& row : rows)
    if (const Row* plain = without_levels(rows, row))
      text +=
          formatted(
              "  levels on %s: %.2f x the step without, strain %.2g rms and %.2g at most instead of %.2g and %.2g\n",
              executor_of(row).c_str(), times_as_long(row, *plain), row.strain.rms, row.strain.max, plain->strain.rms,
              plain->strain.max) +
          set_up_of_levels(row, *plain);
  for (const Row& row : rows) {
    const Row* peer = bullet_of(rows, row);
    if (peer != nullptr && row.library == "malha" && row.schedule == Schedule{10, 1})
      text += formatted("  10x1 on %s: %.1f x as fast as Bullet (1x10, 1 thread), a projection\n",
                        executor_of(row).c_str(), times_as_fast(row, *peer));
  }
  text += setup_lines(rows);
  if (!bullet_left_out.empty()) text += "  Bullet is left out: " + bullet_left_out + "\n";
  return text;
}

}  // namespace malha::bench
