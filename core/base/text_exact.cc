// Doubles as every reader of text gets them back.
#include <cfloat>
#include <cmath>
#include <cstring>

#include "core/base/assert.h"
#include "core/base/text.h"

namespace pirvs {
namespace {

constexpr int kDecimals = 10;
constexpr double kDecimalUnit = 1e10;  // ten to kDecimals
constexpr double kShort_max = 9e5;     // times 1e10: still an exact integer in a double
constexpr int kLongDigits = 18;

// A natural number of up to 1280 bits, least significant limb first.
class Big {
 public:
  explicit Big(uint64_t value) {
    limb_[0] = static_cast<uint32_t>(value);
    limb_[1] = static_cast<uint32_t>(value >> 32);
  }
  void times(uint32_t factor) {
    uint64_t carry = 0;
    for (uint32_t& limb : limb_) {
      carry += uint64_t{limb} * factor;
      limb = static_cast<uint32_t>(carry);
      carry >>= 32;
    }
    PIRVS_ASSERT(carry == 0);
  }
  void times_power(uint32_t base, int exponent) {
    for (int i = 0; i < exponent; ++i) times(base);
  }
  bool less_than(const Big& other) const {
    for (int i = kLimbs - 1; i >= 0; --i) {
      if (limb_[i] != other.limb_[i]) return limb_[i] < other.limb_[i];
    }
    return false;
  }
  void minus(const Big& other) {
    int64_t borrow = 0;
    for (int i = 0; i < kLimbs; ++i) {
      const int64_t difference = int64_t{limb_[i]} - other.limb_[i] + borrow;
      limb_[i] = static_cast<uint32_t>(difference);
      borrow = difference >> 32;
    }
  }

 private:
  static constexpr int kLimbs = 40;
  uint32_t limb_[kLimbs] = {};
};

}  // namespace

TextWriter& TextWriter::exact(double value) {
  if (value != value) return put("nan");
  if (std::signbit(value)) {
    put('-');
    value = -value;
  }
  if (value > DBL_MAX) return put("inf");
  return exact_short(value) ? *this : exact_long(value);
}

// Division rounds correctly, so that i / 1e10 == value says that the reader of the decimal i *
// 1e-10 gets value, bit for bit.
bool TextWriter::exact_short(double value) {
  if (value > kShort_max) return false;
  const auto scaled = static_cast<uint64_t>(value * kDecimalUnit + 0.5);
  if (static_cast<double>(scaled) / kDecimalUnit != value) return false;
  const auto unit = static_cast<uint64_t>(kDecimalUnit);
  unsigned_number(scaled / unit);
  uint64_t decimals = scaled % unit;
  if (decimals == 0) return true;
  int digits = kDecimals;
  for (; decimals % 10 == 0; decimals /= 10) --digits;
  put('.').unsigned_number(decimals, digits);
  return true;
}

// value = numerator / denominator = d.ddd... * 10^exponent, digit by digit.
TextWriter& TextWriter::exact_long(double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  const int biased = static_cast<int>(bits >> 52 & 0x7ff);
  const uint64_t mantissa = (bits & 0xfffffffffffffu) | (biased == 0 ? 0 : uint64_t{1} << 52);
  const int binary = (biased == 0 ? 1 : biased) - 1075;
  Big numerator(mantissa), denominator(1);
  (binary > 0 ? numerator : denominator).times_power(2, binary > 0 ? binary : -binary);
  int exponent = 0;
  for (; !numerator.less_than(denominator); ++exponent) denominator.times(10);
  for (; numerator.less_than(denominator); --exponent) numerator.times(10);
  for (int i = 0; i < kLongDigits; ++i) {
    char digit = '0';
    for (; !numerator.less_than(denominator); ++digit) numerator.minus(denominator);
    put(digit);
    if (i == 0) put('.');
    numerator.times(10);
  }
  return put('e').number(exponent);
}

}  // namespace pirvs
