// Text put together in a fixed buffer, without the C library's printf.
// In      Pieces: text, integers, fixed decimals, exact doubles.
// Out     c_str(): all that fitted, zero-terminated. fixed() writes what printf's "%.*f" writes,
//         digit for digit: the exact value of the double, rounded half to even. exact() writes what
//         reads back to the bit: short where ten decimals say it, otherwise with 18 digits; "nan",
//         "inf".
// Errors  What does not fit is left out; full() says so. fixed() of a value beyond 1e18 or not
//         finite writes "nan".
// Cost    x86-64: fixed() ~60 ns; exact() ~20 ns short, ~2 us long.
// Source  C17 7.21.6.1 (%f); the rounding mode of IEEE 754. 18 digits, cut off, lie within 1e-17 of
//         the value: less than half of a double's last bit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

class TextWriter {
 public:
  static constexpr size_t kNumber = 32;  // the most that an integer or exact() takes

  TextWriter(char* buffer, size_t size) : buffer_(buffer), size_max_(size - 1) { clear(); }
  TextWriter(const TextWriter&) = delete;
  TextWriter& operator=(const TextWriter&) = delete;

  TextWriter& put(const char* text);
  TextWriter& put(char c);
  TextWriter& unsigned_number(uint64_t value, int digits_min = 1);
  TextWriter& number(int64_t value);
  TextWriter& hex(uint64_t value, int digits_min = 1);  // with 0x
  TextWriter& fixed(double value, int decimals);        // at most 9 decimals
  TextWriter& exact(double value);

  void clear() {
    size_ = 0;
    full_ = false;
    buffer_[0] = 0;
  }
  const char* c_str() const { return buffer_; }
  size_t size() const { return size_; }
  size_t room() const { return size_max_ - size_; }
  bool full() const { return full_; }

 private:
  bool exact_short(double value);
  TextWriter& exact_long(double value);

  char* buffer_;
  size_t size_max_;
  size_t size_ = 0;
  bool full_ = false;
};

template <size_t N>
class Text : public TextWriter {
 public:
  Text() : TextWriter(storage_, N) {}

 private:
  char storage_[N];
};

}  // namespace pirvs
