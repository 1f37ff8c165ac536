// Files that are there whole or not at all.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace malha {

/// Writes `bytes` to `path` through "PATH.tmp" and a rename, so that a reader sees the old file or the new one.
/// Throws std::runtime_error "PATH: cannot write: REASON" (full disk, no permission); the temporary file is removed.
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// Throws what write_whole would throw for this path as far as that can be known before; leaves nothing behind.
void check_writable(const std::filesystem::path& path);

/// The bytes of a file. Throws std::runtime_error "PATH: cannot read: REASON".
std::string read_whole(const std::filesystem::path& path);

/// Makes the folder and those above it. Throws std::runtime_error "PATH: cannot make the folder: REASON".
void make_folder(const std::filesystem::path& path);

}  // namespace malha
