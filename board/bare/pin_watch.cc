#include "board/bare/pin_watch.h"

#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/api/cores.h"
#include "bsp/api/gpio.h"
#include "bsp/bare/boot.h"
#include "core/base/text.h"

namespace pirvs::board {
namespace {

constexpr int kDone = 0;
constexpr int kBadInput = 2;
constexpr int kDecimals = 9;

// Reads digits and moves on behind them; -1: there are none, or too many.
int number(const char*& text) {
  int value = -1;
  for (; *text >= '0' && *text <= '9'; ++text) {
    if (value > 9'999) return -1;
    value = (value < 0 ? 0 : 10 * value) + (*text - '0');
  }
  return value;
}

int number_argument(const char* word, int fallback) {
  char buffer[16];
  if (!bsp::boot_argument(word, buffer, sizeof buffer)) return fallback;
  const char* text = buffer;
  const int value = number(text);
  return value < 0 || *text != 0 ? fallback : value;
}

bool pin_argument(bsp::Pin& pin) {
  char buffer[16];
  if (!bsp::boot_argument("watch", buffer, sizeof buffer)) return false;
  const char* text = buffer;
  const int bank = number(text);
  if (bank < 0 || bank > 255 || *text++ != '.') return false;
  const int line = number(text);
  if (line < 0 || line > 255 || *text != 0) return false;
  pin = {static_cast<uint8_t>(bank), static_cast<uint8_t>(line)};
  return true;
}

void say(const bsp::GpioEdge& edge) {
  const TimeNs polled = bsp::now();
  Text<96> line;
  line.put("edge ").number(edge.pin.bank).put('.').number(edge.pin.line);
  line.put(edge.level ? " 1 " : " 0 ");
  line.fixed(to_seconds(edge.t), kDecimals).put(' ').fixed(to_seconds(polled), kDecimals);
  line.put('\n');
  bsp::console_write(line.c_str());
}

}  // namespace

bool pin_watch_wanted() {
  char pin[16];
  return bsp::boot_argument("watch", pin, sizeof pin);
}

int pin_watch() {
  bsp::Pin pin;
  if (!pin_argument(pin) || bsp::gpio_direction(pin, bsp::PinDirection::kInput) != Status::kOk ||
      bsp::gpio_watch(pin, bsp::EdgeKind::kBoth) != Status::kOk) {
    bsp::console_write("watch=: no such pin; BANK.LINE, 4.26 for instance\n");
    return kBadInput;
  }
  bsp::console_write("watching\n");
  const TimeNs period = TimeNs{1'000'000} * number_argument("watch_poll_ms", 10);
  int left = number_argument("watch_edges", 10);
  for (TimeNs due = bsp::now() + period; left > 0; due += period) {
    while (bsp::now() < due) bsp::relax();
    bsp::GpioEdge edge;
    for (Status status = bsp::gpio_poll(pin, edge); status != Status::kEmpty && left > 0; --left) {
      if (status == Status::kFull) bsp::console_write("edges were lost before this one\n");
      say(edge);
      status = bsp::gpio_poll(pin, edge);
    }
  }
  return kDone;
}

}  // namespace pirvs::board
