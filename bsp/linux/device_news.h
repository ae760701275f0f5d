// What a driver of bsp/linux tells a person of its device: one line when it comes, goes or fails.
// In      The device's node or name, and what is so; literals or texts that outlive the call.
// Errors  none. The same news is not told again until something else has happened.
#pragma once

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

}  // namespace pirvs::bsp
