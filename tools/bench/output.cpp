#include "tools/bench/output.h"

#include <iostream>

#include "host/base/file.h"

namespace malha::bench {

void Printer::operator()(const std::string& lines) {
  std::cout << lines << std::flush;
  text_ += lines;
}

Files::Files(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& json)
    : folder_(folder),
      name_(name),
      rows_(folder / (name + ".json")),
      machine_(folder / (name + "_machine.json")),
      table_(folder / (name + ".txt")),
      json_(json) {}

void Files::prepare() const {
  make_folder(folder_);
  if (const auto parent = json_.parent_path(); !parent.empty()) make_folder(parent);
  for (const auto& file : {rows_, machine_, table_, json_})
    if (!file.empty()) check_writable(file);
}

void Files::write(const std::string& rows, const std::string& machine, const std::string& table) const {
  write_whole(rows_, rows);
  write_whole(machine_, machine);
  write_whole(table_, table);
  if (!json_.empty()) write_whole(json_, rows);
}

void Files::list() const {
  std::cout << "\nrows        " << (json_.empty() ? rows_ : json_).string() << "\ntable       " << table_.string()
            << "\nmachine     " << machine_.string() << "\n";
}

void Files::list(const std::string& no_chart) const {
  list();
  if (no_chart.empty())
    std::cout << "chart       " << (folder_ / name_).string() << ".png, " << name_ << ".svg\n";
  else
    std::cerr << "malha bench: no chart: " << no_chart << "\n";
}

}  // namespace malha::bench
