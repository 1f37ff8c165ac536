// SPDX-License-Identifier: Apache-2.0
// Memory that the host writes and device kernels read: ordinary memory, unless a device sets an allocator.
#pragma once
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace malha {

/// Allocator of such memory, in whole cache lines or filled with zeros. It returns null on failure.
struct ReadableMemory {
  void* (*allocate)(std::size_t bytes, bool zeros) = [](std::size_t bytes, bool zeros) {
    constexpr std::size_t line = 64;  // zeros: pages that the system gives where they are touched
    return zeros ? std::calloc(bytes, 1) : std::aligned_alloc(line, (bytes + line - 1) / line * line);
  };
  void (*release)(void* data) = std::free;
};
/// The allocator of new arrays; must be set before any thread makes one.
inline ReadableMemory readable_memory;

/// Standard allocator interface. Each array is released by the allocator that made it.
template <class T>
struct Readable {
  using value_type = T;
  ReadableMemory memory = readable_memory;

  Readable() = default;
  template <class U>
  explicit Readable(const Readable<U>& other) : memory(other.memory) {}
  T* allocate(std::size_t count) {
    if (void* const data = memory.allocate(count * sizeof(T), false)) return static_cast<T*>(data);
    throw std::bad_alloc();
  }
  void deallocate(T* data, std::size_t) { memory.release(data); }
  bool operator==(const Readable& other) const { return memory.release == other.memory.release; }
};
template <class T>
using ReadableVector = std::vector<T, Readable<T>>;

/// Uninitialised numbers, or zeros.
template <class T>
using ReadableArray = std::unique_ptr<T[], void (*)(void*)>;
template <class T>
ReadableArray<T> readable_array(std::size_t count, bool zeros, const ReadableMemory& memory = readable_memory) {
  void* const data = memory.allocate(count * sizeof(T), zeros);
  if (!data) throw std::bad_alloc();
  return {static_cast<T*>(data), memory.release};
}

}  // namespace malha
