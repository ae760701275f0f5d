// Edges of pins on their way from the interrupt handlers to those who poll them: a queue for each
// pin that is watched, so that no watcher takes or delays the edges of another.
// In      watch: for set-up, before the pin's interrupt is on. push: from the core that takes the
//         GPIO interrupts. poll: of one pin, from one core.
// Out     bsp/api/gpio.h, gpio_poll.
// Errors  watch: kFull: kPinsWatchedMax are watched. poll: kNotFound: the pin is not watched.
//         Queue full: the newest edge is lost, counted, and the next poll of the pin says kFull
//         once. push of a pin that is not watched does nothing.
// Cost    A look at kPinsWatchedMax pins and a ring's push or pop; 32 edges a pin, 6 KiB in all.
// Source  bsp/api/gpio.h.
#pragma once

#include <atomic>
#include <cstdint>

#include "bsp/api/gpio.h"
#include "core/store/ring.h"

namespace pirvs::bsp {

class EdgeQueues {
 public:
  Status watch(Pin pin) {
    if (find(pin) != nullptr) return Status::kOk;
    const int count = count_.load(std::memory_order_relaxed);
    if (count == kPinsWatchedMax) return Status::kFull;
    queues_[count].pin = pin;
    count_.store(count + 1, std::memory_order_release);
    return Status::kOk;
  }

  void push(const GpioEdge& edge) {
    Queue* const queue = find(edge.pin);
    if (queue == nullptr || queue->edges.push(edge)) return;
    queue->lost.store(queue->lost.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  Status poll(Pin pin, GpioEdge& out) {
    Queue* const queue = find(pin);
    if (queue == nullptr) return Status::kNotFound;
    const GpioEdge* const edge = queue->edges.front();
    if (edge == nullptr) return Status::kEmpty;
    out = *edge;
    queue->edges.pop();
    const uint32_t lost_now = queue->lost.load(std::memory_order_relaxed);
    const bool lost_some = lost_now != queue->lost_told;
    queue->lost_told = lost_now;
    return lost_some ? Status::kFull : Status::kOk;
  }

 private:
  struct Queue {
    Pin pin;
    Ring<GpioEdge, 32> edges;
    std::atomic<uint32_t> lost{0};
    uint32_t lost_told = 0;
  };

  Queue* find(Pin pin) {
    const int count = count_.load(std::memory_order_acquire);
    for (int i = 0; i < count; ++i) {
      if (queues_[i].pin == pin) return &queues_[i];
    }
    return nullptr;
  }

  Queue queues_[kPinsWatchedMax];
  std::atomic<int> count_{0};
};

}  // namespace pirvs::bsp
