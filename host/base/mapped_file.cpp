// SPDX-License-Identifier: Apache-2.0
#include "host/base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "malha/text.h"

namespace malha {

MappedFile::MappedFile(const std::filesystem::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat facts {};
  bool good = descriptor >= 0 && fstat(descriptor, &facts) == 0;
  size_ = static_cast<std::size_t>(facts.st_size);
  if (good && size_ > 0) {  // mmap refuses a length of 0
    begin_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    good = begin_ != MAP_FAILED;
  }
  const int code = errno;
  if (descriptor >= 0) close(descriptor);
  if (!good) throw std::runtime_error(printable(path.string()) + ": cannot read: " + std::strerror(code));
}

MappedFile::~MappedFile() {
  if (size_ > 0) munmap(begin_, size_);
}

}  // namespace malha
