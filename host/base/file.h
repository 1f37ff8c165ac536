// SPDX-License-Identifier: Apache-2.0
// Atomic writing and reading of whole files, and locks of folders.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace malha {

/// Writes `bytes` to `path` through "PATH.tmp" and a rename, so that a reader sees the old file or the new one.
/// Throws std::runtime_error "PATH: cannot write: REASON" (full disk, no permission); the temporary file is removed.
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// The same for the concatenation of these pieces.
void write_whole(const std::filesystem::path& path, const std::vector<std::string_view>& pieces);

/// The same for what `write` passes to the function that it is given, piece by piece.
void write_whole(const std::filesystem::path& path,
                 const std::function<void(const std::function<void(std::string_view)>& put)>& write);

/// The same as for pieces, and safe from a power failure: file and folder are flushed to disk.
void write_durably(const std::filesystem::path& path, const std::vector<std::string_view>& pieces);

/// Bytes at an offset in a file.
struct PieceAt {
  std::uintmax_t offset;
  std::string_view bytes;
};

/// Overwrites parts of a file, in this order, each flushed before the next: an interruption leaves the last ones as
/// they were. Throws std::runtime_error "PATH: cannot write: REASON".
void overwrite(const std::filesystem::path& path, const std::vector<PieceAt>& pieces);

/// Throws what write_whole() would throw for this path, as far as that can be known before. Leaves no file behind.
void check_writable(const std::filesystem::path& path);

/// The bytes of a file. Throws std::runtime_error "PATH: cannot read: REASON"; OutOfMemory for more than there is free;
/// InputError for a pipe or a device that gives more than 256 MiB, since it may have no end.
std::string read_whole(const std::filesystem::path& path);

/// The same of a file that a user named: InputError that ends in "; allowed: ALLOWED" where it cannot be read.
std::string read_input(const std::filesystem::path& path, const std::string& allowed);

/// Makes the folder and those above it. Throws std::runtime_error "PATH: cannot make the folder: REASON".
void make_folder(const std::filesystem::path& path);

/// Locks a folder against other processes, and other locks of this one, as long as the object exists. The lock is on
/// the open folder itself (flock), so that nothing is left behind, whatever ends the process. File systems without such
/// locks are not protected.
class FolderLock {
 public:
  /// Throws InputError if another process or lock has the folder.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace malha
