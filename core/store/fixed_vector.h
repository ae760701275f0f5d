// A vector whose storage lies inside the object: at most N items, no heap.
// In      Items by value; T must be default constructible and trivially destructible.
// Out     Items in insertion order, contiguous.
// Errors  push_back returns false and append nullptr when full (an expected rejection: count it).
//         An index or size out of range is a bug and asserts.
// Cost    O(1) each; sizeof is N * sizeof(T) plus a count. Items are not cleared: append() and
//         resize() hand out what the slot held before.
// Source  Pigweed InlineQueue, ETL vector.
#pragma once

#include <cstddef>
#include <type_traits>

#include "core/base/assert.h"

namespace pirvs {

template <class T, size_t N>
class FixedVector {
  static_assert(N > 0 && std::is_trivially_destructible_v<T>);

 public:
  [[nodiscard]] bool push_back(const T& item) {
    if (full()) return false;
    items_[size_++] = item;
    return true;
  }
  [[nodiscard]] T* append() { return full() ? nullptr : &items_[size_++]; }
  void pop_back() {
    PIRVS_ASSERT(size_ > 0);
    --size_;
  }
  // Moves the last item into place i.
  void erase_unordered(size_t i) {
    PIRVS_ASSERT(i < size_);
    items_[i] = items_[--size_];
  }
  void clear() { size_ = 0; }
  void resize(size_t size) {
    PIRVS_ASSERT(size <= N);
    size_ = size;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == N; }
  static constexpr size_t capacity() { return N; }

  T& operator[](size_t i) {
    PIRVS_ASSERT(i < size_);
    return items_[i];
  }
  const T& operator[](size_t i) const {
    PIRVS_ASSERT(i < size_);
    return items_[i];
  }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }
  T* data() { return items_; }
  const T* data() const { return items_; }
  T* begin() { return items_; }
  T* end() { return items_ + size_; }
  const T* begin() const { return items_; }
  const T* end() const { return items_ + size_; }

 private:
  size_t size_ = 0;
  T items_[N];
};

}  // namespace pirvs
