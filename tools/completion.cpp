// SPDX-License-Identifier: Apache-2.0
#include "tools/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "host/mesh/io/mesh_io.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

enum class Files { None, Folders, All, Scenes, ScenesAndMeshes };

/// The files that an argument may name, by the type of its value.
Files files_of(const CLI::App& command, const CLI::Option& option) {
  const std::string type = option.get_type_name(), name = option.get_name(true);
  if (name == "SCENE") return command.get_name() == "malha view" ? Files::ScenesAndMeshes : Files::Scenes;
  if (type == "FILE") return Files::All;
  return type == "FOLDER" || type == "DIR..." || name == "OUT" ? Files::Folders : Files::None;
}

/// The words that one_of() allows, which its validator has for a name.
std::vector<std::string> allowed_words(CLI::Option& option) {
  std::vector<std::string> words;
  try {
    std::istringstream names(option.get_validator(0)->get_name());
    for (std::string word; names >> word;) words.push_back(word);
  } catch (const CLI::OptionNotFound&) {
  }
  return words;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// The line of a word and the first line of what it means.
std::string line_of(const std::string& word, const std::string& meaning) {
  return word + "\t" + meaning.substr(0, meaning.find('\n'));
}

/// Paths that begin with `typed`, as it is typed: "~/" stands for the home folder.
void add_paths(std::vector<std::string>& lines, const std::string& typed, Files kind) {
  const std::size_t slash = typed.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : typed.substr(0, slash + 1),
                    begin = typed.substr(folder.size());
  std::string place = folder.empty() ? "." : folder;
  if (const char* home = std::getenv("HOME"); home && typed.starts_with("~/")) place = home + place.substr(1);
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator at(place, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(begin) || (name[0] == '.' && begin.empty()) || name.find('\n') != std::string::npos) continue;
    std::error_code none;
    const bool is_scene = at->path().extension() == ".json";
    if (at->is_directory(none))
      found.push_back(folder + name + "/");
    else if (kind == Files::All || (kind >= Files::Scenes && is_scene) ||
             (kind == Files::ScenesAndMeshes && is_mesh_file(name)))
      found.push_back(folder + name);
  }
  std::ranges::sort(found);
  for (const std::string& path : found) lines.push_back(path + "\t");
}

/// Values that begin with `typed`; of a list, only its last item is completed. `before`: what each line begins with.
void add_values(std::vector<std::string>& lines, const CLI::App& command, CLI::Option& option, const std::string& typed,
                const std::string& before = "") {
  const bool is_list = option.get_type_name() == "LIST";
  const std::size_t comma = is_list ? typed.rfind(',') : std::string::npos;
  const std::string kept = comma == std::string::npos ? "" : typed.substr(0, comma + 1);
  for (const std::string& word : allowed_words(option)) {
    const bool is_there = ("," + kept).find("," + word + ",") != std::string::npos;
    if (word.starts_with(typed.substr(kept.size())) && !is_there) lines.push_back(before + kept + word + "\t");
  }
  if (const Files kind = files_of(command, option); kind != Files::None) {
    std::vector<std::string> paths;
    add_paths(paths, typed, kind);
    for (const std::string& path : paths) lines.push_back(before + path);
  }
}

CLI::App* subcommand_named(CLI::App& command, const std::string& word) {
  for (CLI::App* sub : command.get_subcommands({}))
    if (sub->get_name() == word) return sub;
  return nullptr;
}

CLI::Option* option_named(CLI::App& command, const std::string& word) {
  return word.size() > 1 && word[0] == '-' ? command.get_option_no_throw(word) : nullptr;
}

}  // namespace

std::vector<std::string> completions(CLI::App& app, std::vector<std::string> words) {
  // bash takes "--option=value" for three words.
  for (std::size_t i = 1; i < words.size(); ++i)
    if (words[i] == "=" && words[i - 1].starts_with("--")) {
      if (i + 1 < words.size())
        words.erase(words.begin() + static_cast<std::ptrdiff_t>(i));
      else
        words[i].clear();
    }
  const std::string typed = words.empty() ? "" : words.back();
  if (!words.empty()) words.pop_back();

  CLI::App* command = &app;
  CLI::Option* value_of = nullptr;  // the option whose value comes next
  std::vector<CLI::Option*> given;
  std::size_t arguments = 0;
  for (const std::string& word : words) {
    if (value_of) {
      value_of = nullptr;
    } else if (CLI::Option* option = option_named(*command, word.substr(0, word.find('=')))) {
      given.push_back(option);
      if (takes_value(*option) && word.find('=') == std::string::npos) value_of = option;
    } else if (CLI::App* sub = subcommand_named(*command, word)) {
      command = sub, given.clear(), arguments = 0;
    } else {
      ++arguments;
    }
  }

  std::vector<std::string> lines;
  const std::size_t equals = typed.starts_with("--") ? typed.find('=') : std::string::npos;
  if (value_of) {
    add_values(lines, *command, *value_of, typed);
  } else if (equals != std::string::npos) {
    if (CLI::Option* option = option_named(*command, typed.substr(0, equals)))
      add_values(lines, *command, *option, typed.substr(equals + 1), typed.substr(0, equals + 1));
  } else if (typed.starts_with("-")) {
    for (CLI::Option* option : command->get_options({}))
      for (const std::string& name : option->get_lnames())
        if (("--" + name).starts_with(typed) && std::ranges::count(given, option) == 0)
          lines.push_back(line_of("--" + name, option->get_description()));
  } else {
    for (const CLI::App* sub : command->get_subcommands({}))
      if (sub->get_name().starts_with(typed)) lines.push_back(line_of(sub->get_name(), sub->get_description()));
    for (CLI::Option* option : command->get_options({})) {
      if (!option->get_positional()) continue;
      const auto most = static_cast<std::size_t>(option->get_items_expected_max());
      if (arguments < most) add_values(lines, *command, *option, typed);
      arguments -= std::min(arguments, most);
    }
  }
  return lines;
}

void print_completions(CLI::App& app, const std::vector<std::string>& words) {
  for (const std::string& line : completions(app, words)) std::cout << line << "\n";
}

}  // namespace malha
