// SPDX-License-Identifier: Apache-2.0
#include "host/base/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "host/base/memory_size.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

/// The most bytes that are read from a file that states no size.
constexpr std::size_t kMostWithoutSize = std::size_t{256} << 20;

[[noreturn]] void fail(const fs::path& path, const char* what, int code) {
  throw std::runtime_error(printable(path.string()) + ": cannot " + what + ": " + std::strerror(code));
}

/// Flushes a folder. Some file systems cannot, and some folders cannot be read: then only the file itself is flushed.
void flush_folder(const fs::path& path) {
  const fs::path folder = path.parent_path();
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

using Put = std::function<void(std::string_view)>;
using Write = std::function<void(const Put&)>;

bool write_and_rename(const fs::path& temporary, const fs::path& path, const Write& write, bool flush) {
  File file(std::fopen(temporary.c_str(), "wb"));
  bool good = file != nullptr;
  if (good)
    write([&](std::string_view piece) {
      good = good && std::fwrite(piece.data(), 1, piece.size(), file.get()) == piece.size();
    });
  if (flush) good = good && std::fflush(file.get()) == 0 && fsync(fileno(file.get())) == 0;
  // The file is closed even after an error; a full disk may be reported only here.
  good = file != nullptr && std::fclose(file.release()) == 0 && good;
  return good && std::rename(temporary.c_str(), path.c_str()) == 0;
}

void write(const fs::path& path, const Write& all, bool flush) {
  const fs::path temporary = path.string() + ".tmp";
  errno = 0;
  if (write_and_rename(temporary, path, all, flush)) return;
  const int code = errno;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  fail(path, "write", code);
}

Write each_of(const std::vector<std::string_view>& pieces) {
  return [&pieces](const Put& put) {
    for (const std::string_view piece : pieces) put(piece);
  };
}

}  // namespace

void write_whole(const fs::path& path, std::string_view bytes) {
  write(
      path, [bytes](const Put& put) { put(bytes); }, false);
}

void write_whole(const fs::path& path, const Write& all) { write(path, all, false); }

void write_whole(const fs::path& path, const std::vector<std::string_view>& pieces) {
  write(path, each_of(pieces), false);
}

void write_durably(const fs::path& path, const std::vector<std::string_view>& pieces) {
  write(path, each_of(pieces), true);
  flush_folder(path);
}

void overwrite(const fs::path& path, const std::vector<PieceAt>& pieces) {
  errno = 0;
  File file(std::fopen(path.c_str(), "r+b"));
  bool good = file != nullptr;
  for (const auto& [offset, bytes] : pieces)
    good = good && fseeko(file.get(), static_cast<off_t>(offset), SEEK_SET) == 0 &&
           std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() && std::fflush(file.get()) == 0;
  good = file != nullptr && std::fclose(file.release()) == 0 && good;
  if (!good) fail(path, "write", errno);
}

void check_writable(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) fail(path, "write", EISDIR);
  const fs::path temporary = path.string() + ".tmp";
  errno = 0;
  const File file(std::fopen(temporary.c_str(), "wb"));
  if (!file) fail(path, "write", errno);
  fs::remove(temporary, ignored);
}

std::string read_whole(const fs::path& path) {
  errno = 0;
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, "read", errno);
  std::error_code unknown;  // is set for pipes and devices, which have no size and may have no end
  const auto size = fs::file_size(path, unknown);
  const std::size_t free = available_memory();
  if (!unknown && size > free)
    refuse<OutOfMemory>(path.string(), "", "a file of " + in_gib(double(size)),
                        "what fits into the memory, of which " + in_gib(double(free)) + " are free");
  // The limit is not the size alone, because the file may grow while it is read.
  const std::size_t most = std::max<std::size_t>(unknown ? 0 : size, kMostWithoutSize);
  std::string bytes;
  char block[1 << 16];
  while (const std::size_t count = std::fread(block, 1, sizeof block, file.get())) {
    if (bytes.size() + count > most)
      refuse(path.string(), "", "more than " + std::to_string(most >> 20) + " MiB and no end",
             "a file, or at most so much from a pipe");
    bytes.append(block, count);
  }
  if (std::ferror(file.get())) fail(path, "read", errno);
  return bytes;
}

std::string read_input(const fs::path& path, const std::string& allowed) {
  try {
    return read_whole(path);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw InputError(std::string(error.what()) + "; allowed: " + allowed);
  }
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && fs::is_directory(path)) return;
  throw std::runtime_error(printable(path.string()) +
                           ": cannot make the folder: " + (error ? error.message() : "it is a file"));
}

FolderLock::FolderLock(const fs::path& folder) : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  refuse(folder.string(), "", "another run that is writing to it", "a folder of this run's own (--out)");
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace malha
