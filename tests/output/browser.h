// SPDX-License-Identifier: Apache-2.0
// Headless Chromium, driven over a pipe by its DevTools protocol.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/render/image.h"

namespace malha {

class Browser {
 public:
  using Json = nlohmann::json;

  /// The first known browser on the PATH; "" without one.
  static std::string command();

  Browser(int width, int height);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Opens a page of a run, and waits until it shows its first frame.
  void open(const std::filesystem::path& file);
  /// The value of an expression, awaited. Throws std::runtime_error with the message of what it throws.
  Json evaluate(const std::string& expression);
  Image screenshot();
  void press(const std::string& key);
  void drag(double x, double y, double dx, double dy);
  /// Drags with one finger.
  void swipe(double x, double y, double dx, double dy);

  /// The warnings and errors that the page wrote to the console, and the exceptions that it threw.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  Json call(const std::string& method, const Json& params = Json::object());
  Json receive();
  void note(const Json& event);

  int pid_ = -1, to_ = -1, from_ = -1, last_ = 0;
  std::string session_, read_;
  std::filesystem::path profile_;
  std::vector<std::string> complaints_;
};

}  // namespace malha
