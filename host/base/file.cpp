#include "host/base/file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace malha {

namespace fs = std::filesystem;

namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void fail(const fs::path& path, const char* what, int code) {
  throw std::runtime_error(path.string() + ": cannot " + what + ": " + std::strerror(code));
}

}  // namespace

void write_whole(const fs::path& path, std::string_view bytes) {
  const fs::path temporary = path.string() + ".tmp";
  errno = 0;
  File file(std::fopen(temporary.c_str(), "wb"));
  bool good = file != nullptr;
  good = good && std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  good = file != nullptr && std::fclose(file.release()) == 0 && good;  // closed in any case; a full disk may show here
  good = good && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (good) return;
  const int code = errno;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  fail(path, "write", code);
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
  std::string bytes;
  char block[1 << 16];
  while (const std::size_t count = std::fread(block, 1, sizeof block, file.get())) bytes.append(block, count);
  if (std::ferror(file.get())) fail(path, "read", errno);
  return bytes;
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && fs::is_directory(path)) return;
  throw std::runtime_error(path.string() + ": cannot make the folder: " + (error ? error.message() : "it is a file"));
}

}  // namespace malha
