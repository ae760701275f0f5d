// What an autopilot's GNSS receiver and wheel encoders have measured, as items of the door.
// In      Its messages, and when they came; PeerClock, for their stamps.
// Out     An item. Without TIMESYNC, or with a stamp that is no time of its clock, it has the time
//         at which it came. Wheels: the mean speed between two messages, at the middle of both.
// Frames  GnssFix and WheelSample (modules/door/items.h). Wheel 0 is the left one, 1 the right one.
// Errors  Status: kEmpty: nothing to tell yet (a fix of none, a first distance). kBadData: without
//         accuracy, with numbers that cannot be, with one wheel. kStale: not newer than the last
//         one, or sooner after it than kPeriodMin_ns: a flood.
// Cost    ~20 ns.
// Source  mavlink, common.xml; GPS_FIX_TYPE, GPS_INPUT_IGNORE_FLAGS.
#pragma once

#include "modules/door/items.h"
#include "modules/link/mavlink_messages.h"
#include "modules/link/peer_clock.h"

namespace pirvs {

class RobotSensors {
 public:
  static constexpr TimeNs kPeriodMin_ns = 8'000'000;  // 100 Hz, and room for jitter
  static constexpr TimeNs kAgeMax_ns = 1'000'000'000;

  // GPS_RAW_INT: its height is that above the ellipsoid where it knows one. It has no vertical
  // speed, so the fix has no velocity.
  Status take(TimeNs now, const PeerClock& clock, const mavlink::GpsRawInt& message, GnssFix& out);
  Status take(TimeNs now, const PeerClock& clock, const mavlink::GpsInput& message, GnssFix& out);
  Status take(TimeNs now, const PeerClock& clock, const mavlink::WheelDistance& message,
              WheelSample& out);

 private:
  static TimeNs time_of(TimeNs now, const PeerClock& clock, uint64_t time_usec);
  Status finish(TimeNs now, const PeerClock& clock, uint64_t time_usec, uint8_t fix_type,
                GnssFix& fix);

  TimeNs fix_t_ = INT64_MIN / 2, fix_came_t_ = INT64_MIN / 2;  // of the last one
  TimeNs wheel_came_t_ = INT64_MIN / 2;
  mavlink::WheelDistance wheels_;  // the last one
  bool has_wheels_ = false;
};

}  // namespace pirvs
