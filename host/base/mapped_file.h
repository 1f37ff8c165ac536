// SPDX-License-Identifier: Apache-2.0
// Memory-mapped files, which need not fit into memory.
#pragma once
#include <filesystem>
#include <string_view>

namespace malha {

/// A whole file as memory: the system loads pages on access, and may drop them again. The file must not be shortened.
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
