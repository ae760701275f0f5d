#include "tools/dataset/stamps.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

namespace pirvs::tools {
namespace {

constexpr const char* kNames[] = {"unknown", "ns", "us", "ms", "s"};
constexpr int kDigitsBelowSecond = 9;

int digits_below_second(StampUnit unit) {  // of an integer in this unit
  return kDigitsBelowSecond - 3 * (int(unit) - int(StampUnit::kNanoseconds));
}

double per_second(StampUnit unit) { return std::pow(10, digits_below_second(unit)); }

// mantissa * 10^exponent, as the text has it.
struct Decimal {
  bool negative = false, point = false;
  unsigned __int128 mantissa = 0;
  int exponent = 0;
};

std::optional<Decimal> decimal(std::string_view text) {
  constexpr int kDigitsMax = 34;  // 128 bits hold 38; what comes behind is far below 1 ns
  constexpr int kExponentMax = 60;
  Decimal out;
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) {
    out.negative = text[0] == '-';
    text.remove_prefix(1);
  }
  int digits = 0;
  bool any = false;
  for (; !text.empty(); text.remove_prefix(1)) {
    const char c = text[0];
    if (c == '.' && !out.point) {
      out.point = true;
    } else if (c >= '0' && c <= '9') {
      any = true;
      if (digits == kDigitsMax) {
        out.exponent += out.point ? 0 : 1;
        continue;
      }
      out.mantissa = out.mantissa * 10 + unsigned(c - '0');
      digits += out.mantissa != 0;
      out.exponent -= out.point ? 1 : 0;
    } else {
      break;
    }
  }
  if (!any) return std::nullopt;
  if (text.empty()) return out;
  if (text[0] != 'e' && text[0] != 'E') return std::nullopt;
  text.remove_prefix(1);
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  int exponent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (std::abs(exponent) > kExponentMax) return std::nullopt;
  out.exponent += exponent;
  return out;
}

bool is_date(double stamp, StampUnit unit) {
  constexpr double kYear2000_s = 946'684'800, kYear2100_s = 4'102'444'800;
  const double s = stamp / per_second(unit);
  return s >= kYear2000_s && s < kYear2100_s;
}

// The unit that a heading like "#timestamp [ns]" or "t_us" names for its first column.
StampUnit unit_of_heading(std::string_view heading) {
  const std::string_view first = heading.substr(0, heading.find_first_of(",;\t"));
  for (const StampUnit unit : kStampUnits) {
    const std::string word = name(unit);
    for (const std::string& form : {"[" + word + "]", "(" + word + ")"}) {
      if (first.find(form) != std::string_view::npos) return unit;
    }
    const std::string tail = "_" + word;
    const size_t at = first.rfind(tail);
    if (at != std::string_view::npos && at + tail.size() == first.size()) return unit;
  }
  return StampUnit::kUnknown;
}

// Rows a unit of the stamp; of the middle nine tenths, so that a few wild stamps say nothing.
double rows_per_unit(const std::vector<double>& sorted) {
  const size_t tail = sorted.size() / 20;
  const size_t last = sorted.size() - 1 - tail;
  const double span = sorted[last] - sorted[tail];
  return span > 0 ? double(last - tail) / span : 0;
}

// Units whose rate is possible, the likely one first.
std::vector<StampUnit> units_by_rate(double rows_per_unit, const Rates& rates) {
  constexpr double kNearAnEnd = 2;
  std::vector<StampUnit> out;
  for (const StampUnit unit : kStampUnits) {
    const double hz = rows_per_unit * per_second(unit);
    if (hz >= rates.min_hz && hz < rates.max_hz) {
      out.insert(out.begin(), unit);
    } else if (hz >= rates.min_hz / kNearAnEnd && hz < rates.max_hz * kNearAnEnd) {
      out.push_back(unit);
    }
  }
  return out;
}

bool contains(const std::vector<StampUnit>& units, StampUnit unit) {
  return std::find(units.begin(), units.end(), unit) != units.end();
}

StampUnit unit_by_steps(const std::vector<double>& sorted) {
  constexpr double kSecondsMax = 1000, kNanosecondsMin = 100'000;
  constexpr double kLatest_s = 2e10;  // nobody's clock shows the year 2603
  std::vector<double> steps;
  for (size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] > sorted[i - 1]) steps.push_back(sorted[i] - sorted[i - 1]);
  }
  const bool late = std::max(std::abs(sorted.front()), std::abs(sorted.back())) > kLatest_s;
  if (steps.empty()) return late ? StampUnit::kNanoseconds : StampUnit::kUnknown;
  const auto middle = steps.begin() + std::ptrdiff_t(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (*middle >= kNanosecondsMin) return StampUnit::kNanoseconds;
  return *middle <= kSecondsMax && !late ? StampUnit::kSeconds : StampUnit::kUnknown;
}

}  // namespace

const char* name(StampUnit unit) { return kNames[size_t(unit)]; }

StampUnit stamp_unit(std::string_view text) {
  for (const StampUnit unit : kStampUnits) {
    if (text == name(unit)) return unit;
  }
  return StampUnit::kUnknown;
}

std::optional<TimeNs> stamp_ns(std::string_view text, StampUnit unit) {
  const auto number = decimal(text);
  if (!number || unit == StampUnit::kUnknown) return std::nullopt;
  unsigned __int128 value = number->mantissa;
  int exponent = number->exponent + kDigitsBelowSecond - digits_below_second(unit);
  for (; exponent < 0 && value > 0; ++exponent) value /= 10;
  for (; exponent > 0 && value > 0; --exponent) {
    value *= 10;
    if (value > INT64_MAX) return std::nullopt;
  }
  if (value > INT64_MAX) return std::nullopt;
  return number->negative ? -TimeNs(value) : TimeNs(value);
}

std::optional<double> stamp_number(std::string_view text) {
  const auto number = decimal(text);
  if (!number) return std::nullopt;
  const double value = double(number->mantissa) * std::pow(10.0, number->exponent);
  return number->negative ? -value : value;
}

StampUnit unit_of_stamps(std::vector<double> stamps, bool any_point, std::string_view heading,
                         const StampRule& rule) {
  if (rule.asked != StampUnit::kUnknown || stamps.empty()) return rule.asked;
  std::sort(stamps.begin(), stamps.end());
  const double middle = stamps[stamps.size() / 2];
  const StampUnit said = unit_of_heading(heading);
  const double rate = rule.rates.max_hz > 0 ? rows_per_unit(stamps) : 0;
  if (rate > 0) {
    const auto units = units_by_rate(rate, rule.rates);
    if (units.size() == 1) return units[0];
    for (const StampUnit unit : units) {
      if (is_date(middle, unit)) return unit;
    }
    if (contains(units, rule.others)) return rule.others;
    if (contains(units, said)) return said;
    if (!units.empty()) return StampUnit::kUnknown;
  }
  if (said != StampUnit::kUnknown) return said;
  for (const StampUnit unit : kStampUnits) {
    if (is_date(middle, unit) && (unit != StampUnit::kSeconds || any_point)) return unit;
  }
  if (rate == 0 && rule.others != StampUnit::kUnknown) return rule.others;
  const StampUnit by_steps = unit_by_steps(stamps);
  return by_steps == StampUnit::kUnknown && any_point ? StampUnit::kSeconds : by_steps;
}

}  // namespace pirvs::tools
