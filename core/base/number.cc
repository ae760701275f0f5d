#include "core/base/number.h"

#include <cstddef>
#include <cstdint>

namespace pirvs {
namespace {

constexpr uint64_t kMantissaMax = (UINT64_MAX - 9) / 10;  // room for one more digit
constexpr int kExponentMax = 1000;                        // beyond: infinity or 0 all the same

bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct Reader {
  std::string_view text;
  size_t at = 0;

  bool more() const { return at < text.size(); }
  bool take(char c) {
    if (!more() || text[at] != c) return false;
    ++at;
    return true;
  }
  bool take_sign() {  // true: minus
    const bool minus = take('-');
    if (!minus) (void)take('+');
    return minus;
  }
};

// Digits that no longer fit only move the exponent.
struct Decimal {
  uint64_t mantissa = 0;
  int exponent = 0;

  void add(char digit, bool is_fraction) {
    const bool fits = mantissa <= kMantissaMax;
    if (fits) mantissa = 10 * mantissa + static_cast<uint64_t>(digit - '0');
    if (fits == is_fraction && exponent > -kExponentMax && exponent < kExponentMax) {
      exponent += fits ? -1 : 1;
    }
  }
};

bool read_exponent(Reader& in, int& exponent) {
  const bool minus = in.take_sign();
  if (!in.more()) return false;
  int value = 0;
  for (; in.more(); ++in.at) {
    if (!is_digit(in.text[in.at])) return false;
    if (value < kExponentMax) value = 10 * value + (in.text[in.at] - '0');
  }
  exponent += minus ? -value : value;
  return true;
}

double power_of_ten(int exponent) {  // exact up to 22
  double power = 1.0;
  for (int i = 0; i < exponent; ++i) power *= 10.0;
  return power;
}

__extension__ using Wide = unsigned __int128;
constexpr int kWideExponentMax = 37;  // 10^37 and twice a remainder of it fit

// mantissa / 10^exponent, rounded once: long division, bit by bit, to two bits more than a double
// has, of which the last says whether anything is left.
double divided(uint64_t mantissa, int exponent) {
  Wide divisor = 1;
  for (int i = 0; i < exponent; ++i) divisor *= 10;
  uint64_t quotient = 0;
  Wide rest = 0;
  double unit = 1;
  const auto next = [&](uint64_t bit) {
    rest = 2 * rest + bit;
    const bool one = rest >= divisor;
    if (one) rest -= divisor;
    quotient = 2 * quotient + (one ? 1 : 0);
  };
  for (int i = 63; i >= 0; --i) next(mantissa >> i & 1);
  for (; quotient < uint64_t{1} << 54; unit /= 2) next(0);
  return static_cast<double>(quotient | (rest != 0 ? 1 : 0)) * unit;
}

}  // namespace

bool read_number(std::string_view text, double& value) {
  Reader in{text};
  const bool minus = in.take_sign();
  Decimal decimal;
  bool any = false, is_fraction = false;
  for (; in.more(); ++in.at) {
    const char c = in.text[in.at];
    if (is_digit(c)) {
      decimal.add(c, is_fraction);
      any = true;
    } else if (c == '.' && !is_fraction) {
      is_fraction = true;
    } else {
      break;
    }
  }
  if (!any) return false;
  if (in.take('e') || in.take('E')) {
    if (!read_exponent(in, decimal.exponent)) return false;
  }
  if (in.more()) return false;
  constexpr uint64_t kExact = uint64_t{1} << 53;
  constexpr int kExactExponent = 22;
  const int digits = -decimal.exponent;
  if (digits > 0 && digits <= kWideExponentMax && decimal.mantissa != 0 &&
      (decimal.mantissa > kExact || digits > kExactExponent)) {
    const double size = divided(decimal.mantissa, digits);
    value = minus ? -size : size;
    return true;
  }
  double size = static_cast<double>(decimal.mantissa);
  // In two halves, so that a power beyond the double's range does not make 0 * infinity.
  const int exponent = decimal.exponent < 0 ? -decimal.exponent : decimal.exponent;
  for (int left = exponent; left > 0 && size > 0.0; left -= 300) {
    const double power = power_of_ten(left < 300 ? left : 300);
    size = decimal.exponent < 0 ? size / power : size * power;
  }
  value = minus ? -size : size;
  return true;
}

}  // namespace pirvs
