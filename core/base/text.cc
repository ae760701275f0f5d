#include "core/base/text.h"

#include <cstring>

#include "core/base/assert.h"

namespace pirvs {
namespace {

constexpr int kDecimalsMax = 9;
constexpr uint64_t kTen[kDecimalsMax + 1] = {
    1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000, 1'000'000'000};
constexpr double kFixedMax = 1e18;

__extension__ using Wide = unsigned __int128;

// mantissa * 2^exponent, to the nearest integer, halves to even. mantissa < 2^83, so nothing is
// lost on the left: a value below kFixedMax has exponent <= 7.
Wide scaled(Wide mantissa, int exponent) {
  if (exponent >= 0) return mantissa << exponent;
  const int shift = -exponent;
  if (shift > 100) return 0;  // below a half
  const Wide whole = mantissa >> shift;
  const Wide rest = mantissa - (whole << shift);
  const Wide half = Wide{1} << (shift - 1);
  const bool up = rest > half || (rest == half && (whole & 1) != 0);
  return whole + (up ? 1 : 0);
}

}  // namespace

TextWriter& TextWriter::put(char c) {
  if (size_ == size_max_) {
    full_ = true;
    return *this;
  }
  buffer_[size_++] = c;
  buffer_[size_] = 0;
  return *this;
}

TextWriter& TextWriter::put(const char* text) {
  for (; *text != 0; ++text) put(*text);
  return *this;
}

TextWriter& TextWriter::unsigned_number(uint64_t value, int digits_min) {
  char digits[24];
  int count = 0;
  do {
    digits[count++] = static_cast<char>('0' + value % 10);
    value /= 10;
  } while ((value != 0 || count < digits_min) && count < 20);
  while (count > 0) put(digits[--count]);
  return *this;
}

TextWriter& TextWriter::number(int64_t value) {
  if (value >= 0) return unsigned_number(static_cast<uint64_t>(value));
  put('-');
  return unsigned_number(0 - static_cast<uint64_t>(value));
}

TextWriter& TextWriter::hex(uint64_t value, int digits_min) {
  put("0x");
  int count = 16;
  while (count > 1 && count > digits_min && value >> (4 * (count - 1)) == 0) --count;
  while (count > 0) put("0123456789abcdef"[value >> (4 * --count) & 15]);
  return *this;
}

TextWriter& TextWriter::fixed(double value, int decimals) {
  PIRVS_ASSERT(decimals >= 0 && decimals <= kDecimalsMax);
  if (!(value < kFixedMax && value > -kFixedMax)) return put("nan");
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  if (bits >> 63 != 0) put('-');
  const int biased = static_cast<int>(bits >> 52 & 0x7ff);
  const uint64_t fraction = bits & ((uint64_t{1} << 52) - 1);
  const uint64_t mantissa = biased == 0 ? fraction : fraction | uint64_t{1} << 52;
  const int exponent = (biased == 0 ? 1 : biased) - 1075;
  // Scaled by ten to the decimals: below 2^83 before the shift, below 2^90 after it.
  const Wide number = scaled(Wide{mantissa} * kTen[decimals], exponent);
  unsigned_number(static_cast<uint64_t>(number / kTen[decimals]));
  if (decimals == 0) return *this;
  put('.');
  return unsigned_number(static_cast<uint64_t>(number % kTen[decimals]), decimals);
}

}  // namespace pirvs
