// Counters that another core may read while they count, and their names as rows.
// In      ++ and += from any core. A struct T of Counters and its rows, or an enum that ends in
//         kCount and has name().
// Out     The values by name. Several counters read one after the other are not of one instant.
// Errors  They wrap around after 2^32.
// Cost    A relaxed atomic addition.
// Source  STYLE principle 9. Beside the rows stands the assert that no counter lacks one:
//         every_counter_is_in(rows, bytes of T that are something else).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace pirvs {

template <class Value>
class BasicCounter {
 public:
  // The first value is stored atomically, too: its owner may be made anew in place under a reader.
  BasicCounter(Value value = 0) { value_.store(value, std::memory_order_relaxed); }
  BasicCounter(const BasicCounter& other) : BasicCounter(Value{other}) {}
  BasicCounter& operator=(const BasicCounter& other) {
    value_.store(other, std::memory_order_relaxed);
    return *this;
  }

  operator Value() const { return value_.load(std::memory_order_relaxed); }
  BasicCounter& operator++() { return *this += 1; }
  BasicCounter& operator+=(Value more) {
    value_.fetch_add(more, std::memory_order_relaxed);
    return *this;
  }
  // The largest so far; from one core alone.
  void raise_to(Value value) {
    if (value > *this) value_.store(value, std::memory_order_relaxed);
  }

 private:
  std::atomic<Value> value_;
};

using Counter = BasicCounter<uint32_t>;
static_assert(sizeof(Counter) == sizeof(uint32_t) && std::atomic<uint32_t>::is_always_lock_free);

template <class T>
struct CounterRow {
  const char* name;
  Counter T::*field;
};

template <class T, size_t N>
constexpr bool every_counter_is_in(const CounterRow<T> (&rows)[N], size_t other_bytes = 0) {
  for (size_t i = 0; i < N; ++i) {
    for (size_t j = i + 1; j < N; ++j) {
      if (rows[i].field == rows[j].field) return false;
    }
  }
  return sizeof(T) == N * sizeof(Counter) + other_bytes;
}

// Calls visit(name, value) for every row, in order.
template <class T, size_t N, class Visit>
void for_each_counter(const T& counters, const CounterRow<T> (&rows)[N], Visit&& visit) {
  for (const CounterRow<T>& row : rows) visit(row.name, uint32_t{counters.*row.field});
}

// A counter for each value of an enum.
template <class E>
struct CounterArray {
  static constexpr int kSize = static_cast<int>(E::kCount);
  Counter count[kSize];

  void add(E what) { ++count[static_cast<int>(what)]; }
  uint32_t operator[](E what) const { return count[static_cast<int>(what)]; }
  CounterArray& operator+=(const CounterArray& other) {
    for (int i = 0; i < kSize; ++i) count[i] += other.count[i];
    return *this;
  }
};

template <class E, class Visit>
void for_each_counter(const CounterArray<E>& counters, Visit&& visit) {
  for (int i = 0; i < CounterArray<E>::kSize; ++i) {
    visit(name(static_cast<E>(i)), uint32_t{counters.count[i]});
  }
}

}  // namespace pirvs
