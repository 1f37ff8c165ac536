// SPDX-License-Identifier: Apache-2.0
// Readers of the values of Gmsh files in text (one item per line) and in binary, with a common interface for the
// sections.
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/mesh/io/mesh_scan.h"
#include "malha/error.h"

namespace malha::gmsh {

class TextValues {
 public:
  explicit TextValues(TextScanner& scan) : scan_(scan) {}

  void begin(const std::string& wanted) {
    if (!scan_.next_line()) scan_.refuse_end(wanted);
  }
  /// Starts item i of n.
  void begin(const char* item, long long i, long long n) {
    if (!scan_.next_line()) scan_.refuse_end(item + (" " + std::to_string(i + 1)) + " of " + std::to_string(n));
  }
  void end(const std::string& what) { scan_.require_end_of_line(what); }
  long long whole(const char* wanted) { return scan_.integer(wanted); }
  long long tag(const char* wanted) { return scan_.integer(wanted); }
  double real(const char* wanted) { return scan_.real(wanted); }
  /// A number of items with this many integers, tags and reals each; refused if the rest of the file cannot hold them.
  long long count(const char* wanted, int wholes, int tags, int reals) {
    return scan_.count(wanted, 2 * (wholes + tags + reals));  // a digit and a separator
  }
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const {
    scan_.refuse_here(found, allowed);
  }

 private:
  TextScanner& scan_;
};

class ByteValues {
 public:
  /// `tag_bytes` is the size of counts and of the numbers of nodes and elements in version 4.1: 4 or 8.
  ByteValues(const std::string& file, std::string_view data, std::size_t start, std::endian order,
             std::size_t tag_bytes)
      : file_(file), scan_(file, data, start, order), tag_bytes_(tag_bytes), value_at_(start) {}

  std::size_t offset() const { return scan_.offset(); }
  void begin(const std::string&) { item_ = nullptr; }
  void begin(const char* item, long long i, long long n) { item_ = item, index_ = i, of_ = n; }
  void end(const std::string&) {}
  long long whole(const char* wanted) { return number<std::int32_t>(wanted); }
  long long tag(const char* wanted) {
    if (tag_bytes_ == 4) return number<std::uint32_t>(wanted);
    const std::uint64_t value = number<std::uint64_t>(wanted);
    if (value >> 63) refuse_here(std::to_string(value) + " as " + wanted, "a number below 2^63");
    return static_cast<long long>(value);
  }
  double real(const char* wanted) {
    const double value = number<double>(wanted);
    if (!std::isfinite(value)) refuse_here("a NaN or infinite " + std::string(wanted), "a finite number");
    return value;
  }
  long long count(const char* wanted, int wholes, int tags, int reals) {
    const long long count = tag(wanted);
    const std::size_t each = 4 * wholes + tag_bytes_ * tags + 8 * reals;
    const auto most = static_cast<long long>(scan_.bytes_left() / each);
    if (count > most)
      refuse_here(std::to_string(count) + " as " + wanted,
                  "0 to " + std::to_string(most) + ", as many as the rest of the file can hold");
    return count;
  }
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const {
    refuse(file_, "byte " + std::to_string(value_at_), found, allowed);
  }

 private:
  template <class T>
  T number(const char* wanted) {
    value_at_ = scan_.offset();
    if (scan_.bytes_left() < sizeof(T))
      scan_.refuse_end(
          wanted +
          (item_ ? std::string(" of ") + item_ + " " + std::to_string(index_ + 1) + " of " + std::to_string(of_) : ""));
    return scan_.get<T>();
  }

  std::string file_;
  ByteScanner scan_;
  std::size_t tag_bytes_, value_at_;
  const char* item_ = nullptr;  // kind of the item that is being read, which is item index_ of of_
  long long index_ = 0, of_ = 0;
};

}  // namespace malha::gmsh
