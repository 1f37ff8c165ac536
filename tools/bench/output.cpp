// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/output.h"

#include <iostream>

#include "host/base/file.h"

namespace malha::bench {

void require_writable(const std::filesystem::path& file) {
  if (const auto folder = file.parent_path(); !folder.empty()) make_folder(folder);
  check_writable(file);
}

Output::Output(const std::string& name, const MeasuringOptions& options)
    : folder_(options.out.empty() ? "out/bench_" + name : options.out),
      name_(name),
      rows_(folder_ / (name + ".json")),
      machine_(folder_ / (name + "_machine.json")),
      table_(folder_ / (name + ".txt")),
      json_(options.json) {
  for (const auto& file : {rows_, machine_, table_, json_})
    if (!file.empty()) require_writable(file);
}

void Output::print(const std::string& lines) {
  status_.clear();
  std::cout << lines << std::flush;
  printed_ += lines;
}

void Output::write(const nlohmann::ordered_json& rows) const {
  const std::string text = rows.dump(2) + "\n";
  write_whole(rows_, text);
  write_whole(machine_, facts.dump(2) + "\n");
  write_whole(table_, printed_);
  if (!json_.empty()) write_whole(json_, text);
}

void Output::list() const {
  std::cout << "\nrows        " << (json_.empty() ? rows_ : json_).string() << "\ntable       " << table_.string()
            << "\nmachine     " << machine_.string() << "\n";
}

void Output::list_chart(const std::string& no_chart) const {
  if (no_chart.empty())
    std::cout << "chart       " << (folder_ / name_).string() << ".png, " << name_ << ".svg\n";
  else
    std::cerr << "malha bench: no chart: " << no_chart << "\n";
}

}  // namespace malha::bench
