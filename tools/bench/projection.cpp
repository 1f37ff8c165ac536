#include "tools/bench/projection.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/build_info.h"
#include "host/base/file.h"
#include "host/base/shown.h"
#include "host/error.h"
#include "host/simulation.h"
#include "tools/bench/chart.h"
#include "tools/bench/machine.h"
#include "tools/bench/measure.h"
#include "tools/bench/status.h"
#include "tools/bench/table.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

struct Planned {
  bool grid;
  int n;
};

std::vector<int> sorted(std::vector<int> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

std::vector<Planned> plan(const Options& options) {
  std::vector<Planned> cases;
  const std::vector<int> given = sorted(options.n);
  const bool irregular = options.only == "irregular" || (options.only.empty() && options.n.empty());
  if (options.only != "irregular")
    for (const int n : given.empty() ? std::vector{17, 46, 100, 316, 1000} : given) cases.push_back({true, n});
  if (irregular)
    for (const int n : given.empty() ? std::vector{100'000} : given) cases.push_back({false, n});
  return cases;
}

int cores() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

std::vector<int> thread_counts(const Options& options) {
  return sorted(options.threads.empty() ? std::vector{1, cores()} : options.threads);
}

/// What was measured on, and how fast that is.
Json machine_facts(const std::vector<int>& threads, double root_ns) {
  const Json report = Json::parse(Simulation(hanging(grid_case(3), {})).report("benchmark"));
  Json facts;
  for (const char* key : {"malha_version", "compiler", "flags", "instructions", "cpu"}) facts[key] = report.at(key);
  facts["cores"] = cores();
  if (!peer_version().empty()) facts["bullet_version"] = peer_version();
  facts["triad_bytes"] = kMemoryBytes;
  for (const int t : threads)
    facts["triad_gb_per_s"].push_back({{"threads", t}, {"gb_per_s", triad_gb_per_s(kMemoryBytes, t)}});
  facts["root_and_quotient_ns"] = root_ns;
  return facts;
}

std::string introduction(const Options& options, const Json& facts) {
  char text[600];
  std::snprintf(text, sizeof text,
                "A hanging cloth in float, dt = 1/60 s: %d steps of warm-up, then %d x %g s a line, taking turns; "
                "medians.\nStrain and state are those after the warm-up. The floor is the larger of memory (the triad "
                "at that size)\nand arithmetic (a square root and a division, %.3f ns on 1 thread).\n",
                kWarmUpSteps, options.repeats, options.seconds, facts["root_and_quotient_ns"].get<double>());
  std::string all = text;
  const auto fact = [&facts](const char* key) { return facts[key].get<std::string>(); };
  all += "malha " + fact("malha_version") + ", " + fact("compiler") + ", " + fact("instructions") + "; " +
         (peer_version().empty() ? "" : "Bullet " + peer_version() + "; ") + fact("cpu") + "\ntriad from memory:";
  for (const Json& triad : facts["triad_gb_per_s"]) {
    std::snprintf(text, sizeof text, " %.1f GB/s on ", triad["gb_per_s"].get<double>());
    all +=
        text + counted(triad["threads"].get<int>(), "thread") + (triad == facts["triad_gb_per_s"].back() ? "\n" : ",");
  }
  return all;
}

/// Prints, and keeps what was printed.
class Printer {
 public:
  void operator()(const std::string& lines) {
    std::cout << lines << std::flush;
    text_ += lines;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The files of the results by path; charts aside.
class Files {
 public:
  explicit Files(const Options& options)
      : folder_(options.out),
        rows_(folder_ / "projection.json"),
        machine_(folder_ / "projection_machine.json"),
        table_(folder_ / "projection.txt"),
        json_(options.json) {}

  /// Whether they can be written is known now, not after minutes.
  void prepare() const {
    make_folder(folder_);
    if (const auto parent = json_.parent_path(); !parent.empty()) make_folder(parent);
    for (const auto& file : {rows_, machine_, table_, json_})
      if (!file.empty()) check_writable(file);
  }

  void write(const std::vector<Row>& rows, const Json& facts, const std::string& table) const {
    write_whole(rows_, to_json(rows));
    write_whole(machine_, facts.dump(2) + "\n");
    write_whole(table_, table);
    if (!json_.empty()) write_whole(json_, to_json(rows));
  }

  std::string list() const {
    return "\nrows        " + (json_.empty() ? rows_ : json_).string() + "\ntable       " + table_.string() +
           "\nmachine     " + machine_.string() + "\n";
  }

 private:
  std::filesystem::path folder_, rows_, machine_, table_, json_;
};

/// The most that the lines of a case take up while they take turns.
void check_memory(const std::vector<Planned>& cases, const Timing& timing) {
  const double free = free_memory_bytes(), lines = static_cast<double>(lines_of_malha(timing));
  for (const Planned& planned : cases) {
    const double particles = planned.grid ? double(planned.n) * planned.n : planned.n;
    const double needed = particles * (lines * kLineBytes + kSetUpBytes);
    if (free <= 0 || needed <= free) continue;
    char needs[160], has[80];
    std::snprintf(needs, sizeof needs, "%d, which takes about %.3g GiB: %g lines of %.3g particles", planned.n,
                  needed / (1 << 30), lines, particles);
    std::snprintf(has, sizeof has, "what fits into the %.3g GiB that are free; fewer threads have fewer lines",
                  free / (1 << 30));
    refuse("malha bench projection", "--n", needs, has);
  }
}

}  // namespace

void run_projection(const Options& options) {
  Timing timing;
  timing.threads = thread_counts(options), timing.repeats = options.repeats, timing.seconds = options.seconds;
  const std::vector<Planned> cases = plan(options);
  check_memory(cases, timing);
  const Files files(options);
  files.prepare();
  Status status;
  Printer print;
  status.show("measuring the machine", 0);
  const double root_ns = root_and_quotient_ns();
  const Json facts = machine_facts(timing.threads, root_ns);
  status.clear();
  print(introduction(options, facts));

  std::vector<Row> all;
  std::string no_chart;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    Case which = cases[k].grid ? grid_case(cases[k].n) : irregular_case(cases[k].n);
    const std::string name = which.name + " " + std::to_string(which.n) + ", ";
    const std::string left_out = bullet_left_out(which);
    std::vector<Row> rows = measure(std::move(which), timing, [&](const std::string& what, double part) {
      status.show(name + what, (static_cast<double>(k) + part) / static_cast<double>(cases.size()));
    });
    std::map<int, double> triad;  // by threads
    for (Row& row : rows) {
      if (!triad.contains(row.threads))
        triad[row.threads] = triad_gb_per_s(static_cast<std::size_t>(working_set_bytes(row)), row.threads);
      set_floor(row, triad[row.threads], root_ns, cores());
    }
    status.clear();
    print(table(rows, left_out));
    all.insert(all.end(), rows.begin(), rows.end());
    files.write(all, facts, print.text());  // now: what ends the next case takes none of this one away
    no_chart = draw_chart(all, options.out);
  }
  std::cout << files.list();
  if (no_chart.empty())
    std::cout << "chart       " << options.out << "/projection.png, projection.svg\n";
  else
    std::cerr << "malha bench: no chart: " << no_chart << "\n";
}

}  // namespace malha::bench
