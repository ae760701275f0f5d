// The last speeds of the wheels, by number and by the IMU sample that each came after.
// In      speeds in order of time.
// Out     any of them; the way that they say lies between two of the IMU's times.
// Errors  what is missing shows in WheelPath::holds().
// Cost    75 kB; wheel_path.h. Owner and readers share one core.
// Source  own.
#pragma once

#include "core/base/assert.h"
#include "modules/imu/imu_history.h"
#include "modules/wheels/wheel_path.h"

namespace pirvs {

class WheelHistory {
 public:
  static constexpr size_t kCapacity = 1024;  // 10 s at 100 Hz
  struct Entry {
    TimeNs sample_t = 0;  // of the newest IMU sample when it came
    WheelVelocity velocity;
    bool slips = false;  // it was not used
  };

  void clear() { end_ = 0; }
  void add(const Entry& entry) { entries_[end_++ % kCapacity] = entry; }
  // Entries are counted from clear() on; begin() to end() - 1 are still there.
  size_t begin() const { return end_ > kCapacity ? end_ - kCapacity : 0; }
  size_t end() const { return end_; }
  const Entry& operator[](size_t number) const {
    PIRVS_ASSERT(number >= begin() && number < end_);
    return entries_[number % kCapacity];
  }
  // The first entry after the IMU sample at t; end(): there is none yet.
  size_t first_after(TimeNs t) const;

 private:
  Entry entries_[kCapacity];
  size_t end_ = 0;
};

// The way between the IMU samples from t0 to t1 at a given bias; `path`, configured, says how
// wheels are to be taken.
WheelPath integrate(const ImuHistory& imu, const WheelHistory& wheels, TimeNs t0, TimeNs t1,
                    const Vec3& b_g, const ImuNoise& noise, WheelPath path);

}  // namespace pirvs
