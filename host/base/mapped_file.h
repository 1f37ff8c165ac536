// SPDX-License-Identifier: Apache-2.0
// The bytes of a file that need not fit into memory.
#pragma once
#include <filesystem>
#include <string_view>

namespace malha {

/// A whole file, mapped: the system reads what is looked at, and may forget it again. Nobody may shorten it meanwhile.
class MappedFile {
 public:
  /// Throws std::runtime_error "PATH: cannot read: REASON".
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::string_view bytes() const { return {static_cast<const char*>(begin_), size_}; }

 private:
  void* begin_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace malha
