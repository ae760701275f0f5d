// Edges of pins on their way from the interrupt handlers to the one who polls them.
// In      push: from the core that takes the GPIO interrupts. poll: from one core.
// Out     bsp/api/gpio.h, gpio_poll.
// Errors  Full: the newest edge is lost, counted, and the next poll says kFull once.
// Cost    A ring's push or pop; 64 edges are 1.5 KiB.
// Source  bsp/api/gpio.h.
#pragma once

#include <atomic>
#include <cstdint>

#include "bsp/api/gpio.h"
#include "core/store/ring.h"

namespace pirvs::bsp {

class EdgeQueue {
 public:
  void push(const GpioEdge& edge) {
    if (!edges_.push(edge)) lost_.store(lost() + 1, std::memory_order_relaxed);
  }

  Status poll(GpioEdge& out) {
    const GpioEdge* edge = edges_.front();
    if (edge == nullptr) return Status::kEmpty;
    out = *edge;
    edges_.pop();
    const uint32_t lost_now = lost();
    const bool lost_some = lost_now != lost_told_;
    lost_told_ = lost_now;
    return lost_some ? Status::kFull : Status::kOk;
  }

  uint32_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  Ring<GpioEdge, 64> edges_;
  std::atomic<uint32_t> lost_{0};
  uint32_t lost_told_ = 0;
};

}  // namespace pirvs::bsp
