// TableText of tables in memory of a fixed size, without the C library: numbers as every reader of
// text gets them back exactly.
// In      Words, integers, doubles.
// Out     view(), size(). A double comes out short where ten decimals say it exactly, otherwise
//         with 18 digits; "nan", "inf".
// Frames  none.
// Errors  What does not fit is a bug and asserts: the caller keeps room().
// Cost    short doubles ~20 ns, long ones ~2 us (x86-64).
// Source  18 digits, cut off, lie within 1e-17 of the value: less than half of a double's last bit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

class TableText {
 public:
  static constexpr size_t kSize = 4096;
  static constexpr size_t kNumber = 32;  // the most that one number takes

  TableText& add(const char* words);
  TableText& add(int64_t value);
  TableText& add(double value);
  void clear() { size_ = 0; }

  const char* data() const { return text_; }
  const char* c_str();
  size_t size() const { return size_; }
  size_t room() const { return kSize - size_; }

 private:
  void put(char c);
  void add_digits(uint64_t value);
  bool add_short(double value);
  void add_long(double value);

  char text_[kSize + 1];  // and the zero of c_str()
  size_t size_ = 0;
};

}  // namespace pirvs
