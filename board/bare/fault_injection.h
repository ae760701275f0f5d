// Faults on purpose, so that anybody can see what becomes of them.
// In      The command line: fault=KIND, fault_at=FRAME, fault_core=CORE, which must be at rest.
// Out     on_frame() does what was asked for when that frame has been reported, and does not come
//         back.
// Errors  configure: false, no such kind.
// Cost    A comparison a frame.
// Source  bsp/bare/fault.h.
#pragma once

#include <cstdint>

namespace pirvs::board {

class FaultInjection {
 public:
  bool configure();
  void on_frame(uint32_t frame) const {
    if (kind_ != Kind::kNone && frame == at_) begin();
  }

 private:
  enum class Kind : uint8_t { kNone, kNull, kStack, kHang, kAssert };
  void begin() const;
  void strike() const;

  Kind kind_ = Kind::kNone;
  uint32_t at_ = 0;
  uint32_t core_ = 0;  // 0: wherever the frame is reported
};

}  // namespace pirvs::board
