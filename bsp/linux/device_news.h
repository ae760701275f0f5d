// What a driver of bsp/linux tells of a device that comes, goes or fails: a line for a person, and
// the answer to whoever polls it.
// In      The device's node or name, and what is so; literals or texts that outlive the call.
// Out     GoneDevice::answer(): kBusFault once every kFaultEvery_ns, kEmpty in between, so that a
//         caller that polls until kEmpty comes to an end.
// Errors  none. The same news is not told again until something else has happened.
#pragma once

#include "bsp/api/clock.h"
#include "core/base/status.h"

namespace pirvs::bsp {

struct DeviceNews {
  void* context = nullptr;
  void (*tell)(void*, const char* device, const char* what) = nullptr;
};

class DeviceTeller {
 public:
  void configure(const DeviceNews& news) {
    news_ = news;
    told_ = nullptr;
  }
  void tell(const char* device, const char* what) {
    if (what == told_) return;
    told_ = what;
    if (news_.tell != nullptr) news_.tell(news_.context, device, what);
  }

 private:
  DeviceNews news_;
  const char* told_ = nullptr;
};

class GoneDevice {
 public:
  static constexpr TimeNs kFaultEvery_ns = 10'000'000;

  Status answer() {
    if (now() < next_t_) return Status::kEmpty;
    next_t_ = now() + kFaultEvery_ns;
    return Status::kBusFault;
  }

 private:
  TimeNs next_t_ = 0;
};

}  // namespace pirvs::bsp
