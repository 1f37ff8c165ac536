// SPDX-License-Identifier: Apache-2.0
// Arrays in the memory of an executor. A backend with memory of its own specialises Memory; solvers use only Array.
#pragma once
#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <new>
#include <span>
#include <utility>
#include <vector>

namespace malha {

/// Asks for huge pages: a sweep over a large mesh uses more arrays than the TLB has entries for small pages.
inline void prefer_huge_pages([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;
  const auto begin = (reinterpret_cast<std::uintptr_t>(data) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(data) + bytes) / page * page;
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // advice: may be refused
#endif
}

/// Memory of the program for the arrays that this thread makes; null: operator new. Simulation sets it for the duration
/// of its calls (SimulationOptions::memory), and every array remembers it, so that it goes back where it came from.
inline thread_local std::pmr::memory_resource* array_resource = nullptr;

/// Memory of an executor's arrays. This one is for every executor on the host.
template <class Executor>
struct Memory {
  static constexpr std::size_t kAlignment = 64;  // one pack, one cache line
  /// `resource`: of the program; null: none.
  static void* allocate(std::size_t bytes, std::pmr::memory_resource* resource) {
    if (resource != nullptr) return resource->allocate(bytes, kAlignment);
    void* data = ::operator new (bytes, std::align_val_t{kAlignment});
    prefer_huge_pages(data, bytes);
    return data;
  }
  static void release(void* data, std::size_t bytes, std::pmr::memory_resource* resource) {
    if (resource != nullptr) return resource->deallocate(data, bytes, kAlignment);
    ::operator delete (data, std::align_val_t{kAlignment});
  }
  template <class T>
  static void fill(T* to, std::size_t count, const T& value) {
    std::uninitialized_fill_n(to, count, value);
  }
  template <class T>
  static void copy_in(const T* from, std::size_t count, T* to) {
    std::copy_n(from, count, to);
  }
  template <class T>
  static void copy_out(const T* from, std::size_t count, T* to) {
    std::copy_n(from, count, to);
  }
  /// Copies within this memory.
  template <class T>
  static void copy(const T* from, std::size_t count, T* to) {
    std::copy_n(from, count, to);
  }
  template <class T>
  static bool has(const T* from, std::size_t count, const T& value) {
    return std::find(from, from + count, value) != from + count;
  }
  static constexpr bool kOnHost = true;  // the host may write to it without a copy
};

/// A fixed number of plain T in the executor's memory; empty arrays allocate nothing.
template <class Executor, class T>
class Array {
 public:
  Array() = default;
  explicit Array(const std::vector<T>& values) : Array(values.size()) {
    if (size_ > 0) upload(values);
  }
  /// Uninitialised memory, of which pages that are never written are never allocated.
  explicit Array(std::size_t size) : size_(size) {
    if (size_ > 0) data_ = static_cast<T*>(Memory<Executor>::allocate(bytes(), resource_));
  }
  Array(std::size_t size, const T& value) : Array(size) {
    if (size_ > 0) Memory<Executor>::fill(data_, size_, value);
  }
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Array() {
    if (data_) Memory<Executor>::release(data_, bytes(), resource_);
  }

  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }

  void fill(const T& value) {
    if (size_ > 0) Memory<Executor>::fill(data_, size_, value);
  }
  /// `values` has size() elements.
  void upload(const std::vector<T>& values) { Memory<Executor>::copy_in(values.data(), size_, data_); }
  std::vector<T> download() const {
    std::vector<T> values(size_);
    Memory<Executor>::copy_out(data_, size_, values.data());
    return values;
  }
  /// The elements where the host reads them: in place, or copied to `staging`.
  std::span<const T> on_host([[maybe_unused]] std::vector<T>& staging) const {
    if constexpr (Memory<Executor>::kOnHost) {
      return {data_, size_};
    } else {
      staging.resize(size_);
      Memory<Executor>::copy_out(data_, size_, staging.data());
      return staging;
    }
  }
  T get(std::size_t i) const {
    T value;
    Memory<Executor>::copy_out(data_ + i, 1, &value);
    return value;
  }

 private:
  void swap(Array& other) {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(resource_, other.resource_);
  }
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::pmr::memory_resource* resource_ = array_resource;
};

/// An array that the host fills piece by piece, in place or in host memory until it is uploaded.
template <class Executor, class T>
class FilledArray {
 public:
  FilledArray() = default;
  FilledArray(std::size_t size, const T& value) : array_(size, value) {
    if (!Memory<Executor>::kOnHost) own_.assign(size, value);
  }
  T* to_fill() { return Memory<Executor>::kOnHost ? array_.data() : own_.data(); }
  const T* filled() const { return Memory<Executor>::kOnHost ? array_.data() : own_.data(); }
  void send() {
    if (!Memory<Executor>::kOnHost) array_.upload(own_), own_ = {};
  }
  T* data() const { return array_.data(); }
  std::size_t bytes() const { return array_.bytes(); }

 private:
  Array<Executor, T> array_;
  std::vector<T> own_;
};

}  // namespace malha
