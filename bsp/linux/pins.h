// Pins of Linux: outputs by libgpiod, edges by the kernel's second line interface, since the first,
// which libgpiod 1.6 uses, keeps 16 edges a line and loses more without a word.
// In      A pin's name: that of its line, as gpioinfo lists it, SYNC_OUT; or its chip and offset,
//         gpiochip2:11, where the chip may also be named by its label. `user`: what gpioinfo shows.
//         EdgePins::find() looks the names up, with libgpiod's heap; open() takes none.
// Out     OutputPin::write: the level is driven at once. EdgePins::poll: the oldest edge of its
//         pins, those of all of them in the order in which they came. t: CLOCK_MONOTONIC, taken in
//         the kernel's interrupt handler.
// Errors  find, open: nullptr, or why not, for a person. EdgePins::poll: kEmpty: nothing now;
//         kFull: edges were lost before this one, which is good; kBusFault: the chip is gone.
// Cost    A system call a write; one for up to 64 edges. No heap but libgpiod's, in find()
//         and OutputPin::open().
// Source  kernel, include/uapi/linux/gpio.h; docs/adr/0011-pins-of-linux.md.
#pragma once

#include "bsp/api/gpio.h"
#include "bsp/linux/system_calls.h"
#include "core/base/counter.h"

struct gpiod_chip;
struct gpiod_line;
struct gpio_v2_line_event;

namespace pirvs::bsp {

// Of two pins at most, an encoder's: one queue of the kernel keeps their order.
class EdgePins {
 public:
  static constexpr int kPinsMax = 2;
  static constexpr uint32_t kKernelEdges = 1024;  // the most that the kernel keeps: 51 ms at 20 kHz

  const char* find(const char* const* names, int count);
  // Of those found.
  const char* open(EdgeKind kind, const char* user, const SystemCalls& calls = kSystemCalls);
  void close();
  Status poll(GpioEdge& out);

  bool is_open() const { return fd_ >= 0; }
  int fd() const { return fd_; }
  // Which of the names an edge belongs to.
  int index_of(Pin pin) const { return count_ > 1 && pin == pins_[1] ? 1 : 0; }
  Pin pin(int i) const { return pins_[i]; }
  uint32_t lost() const { return lost_; }

 private:
  static constexpr int kBatch = 64;

  bool refill();

  const SystemCalls* calls_ = &kSystemCalls;
  int fd_ = -1;
  char path_[32] = "";  // of their chip; empty: not found
  Pin pins_[kPinsMax];
  int count_ = 0;
  GpioEdge edges_[kBatch];
  uint32_t lost_before_[kBatch] = {};
  int here_ = 0, at_ = 0;
  uint32_t seen_ = 0;  // the kernel's number of the last edge; 0: none yet
  Counter lost_;
};

class OutputPin {
 public:
  ~OutputPin() { close(); }

  const char* open(const char* name, bool level, const char* user);
  // Leaves the pin low.
  void close();
  Status write(bool level);

  bool is_open() const { return line_ != nullptr; }

 private:
  gpiod_chip* chip_ = nullptr;
  gpiod_line* line_ = nullptr;
};

}  // namespace pirvs::bsp
