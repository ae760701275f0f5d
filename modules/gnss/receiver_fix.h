// What a GNSS receiver says, whatever its language: a fix, and when by its own clock.
// Units   t_utc: ns since 1970, UTC without leap seconds, as Unix time; deg, m, m/s.
// Errors  none.
#pragma once

#include "modules/door/items.h"

namespace pirvs {

struct ReceiverFix {
  GnssFix fix;  // t is left 0: the caller knows the device's clock
  bool has_time = false;
  TimeNs t_utc = 0;
  bool overdue = false;  // told by the beginning of the next one: it came long before
};

// Days from 1970-01-01 to a date of the Gregorian calendar.
// Source  Hinnant, "chrono-Compatible Low-Level Date Algorithms", days_from_civil.
constexpr int64_t days_since_1970(int64_t year, int month, int day) {
  year -= month <= 2 ? 1 : 0;
  const int64_t era = (year >= 0 ? year : year - 399) / 400;
  const int64_t of_era = year - era * 400;
  const int64_t of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}
static_assert(days_since_1970(1970, 1, 1) == 0 && days_since_1970(2000, 3, 1) == 11017);

}  // namespace pirvs
