// What    What a column of stamps counts: ns, us, ms or s, since 1970 or since a device was
//         started, as integers, decimals or with an exponent.
// In      The column as text, its heading, at which rates rows of its kind come, what is known of
//         the recording's other tables.
// Out     The unit, decided by the first of these that decides:
//           asked for (--stamps);
//           the rate that results: rates of a kind span three decades, so one unit alone fits. Near
//           an end of them two may: then the one that gives a date between 2000 and 2100, that of
//           the other tables, that of the heading;
//           where the rate says nothing: the heading, the date, the steps, the decimal point.
// Units   TimeNs, exact to the nanosecond; digits below it are cut off.
// Errors  kUnknown: ask for it.
// Cost    one sort of the column.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace pirvs::tools {

enum class StampUnit : uint8_t { kUnknown, kNanoseconds, kMicroseconds, kMilliseconds, kSeconds };
inline constexpr StampUnit kStampUnits[] = {StampUnit::kNanoseconds, StampUnit::kMicroseconds,
                                            StampUnit::kMilliseconds, StampUnit::kSeconds};
const char* name(StampUnit unit);             // "ns"
StampUnit stamp_unit(std::string_view name);  // kUnknown: no such unit

// Rates that rows of a kind come at; {}: any.
struct Rates {
  double min_hz = 0, max_hz = 0;
};
inline constexpr Rates kCameraRates = {1, 1'000};
inline constexpr Rates kImuRates = {20, 20'000};

struct StampRule {
  Rates rates;
  StampUnit asked = StampUnit::kUnknown;
  StampUnit others = StampUnit::kUnknown;  // of the recording's other tables
};

// The stamp that the text stands for; nullopt: not a number, or one that no clock shows.
std::optional<TimeNs> stamp_ns(std::string_view text, StampUnit unit);
// The same as a plain number, near enough to compare.
std::optional<double> stamp_number(std::string_view text);

StampUnit unit_of_stamps(std::vector<double> stamps, bool any_point, std::string_view heading,
                         const StampRule& rule);

}  // namespace pirvs::tools
