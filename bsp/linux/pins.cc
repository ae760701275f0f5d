#include "bsp/linux/pins.h"

#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <linux/gpio.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "core/base/assert.h"
#include "core/base/text.h"

namespace pirvs::bsp {
namespace {

constexpr size_t kNameMax = 64;
constexpr const char* kNoSuchPin = "no such pin: gpioinfo lists them";

const char* reason_of_errno() {
  switch (errno) {
    case EBUSY:
      return "the pin is busy: another program or driver holds it, gpioinfo says which";
    case EACCES:
    case EPERM:
      return "no right to use the pin: the group gpio, or root";
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case EINVAL:
      return kNoSuchPin;
    default:
      return std::strerror(errno);
  }
}

struct Place {
  char chip[kNameMax] = "";  // its name, gpiochip2, or its label
  unsigned offset = 0;
};

// Of `chip:offset`; else libgpiod looks for a line of that name.
bool find_place(const char* name, Place& out) {
  const char* const colon = std::strrchr(name, ':');
  if (colon == nullptr) {
    return gpiod_ctxless_find_line(name, out.chip, sizeof out.chip, &out.offset) == 1;
  }
  const auto length = static_cast<size_t>(colon - name);
  char* end = nullptr;
  const unsigned long offset = std::strtoul(colon + 1, &end, 10);
  if (length == 0 || length >= sizeof out.chip || end == colon + 1 || *end != 0) return false;
  std::memcpy(out.chip, name, length);
  out.chip[length] = 0;
  out.offset = static_cast<unsigned>(offset);
  return offset <= UINT8_MAX;
}

uint64_t flags_of(EdgeKind kind) {
  uint64_t flags = GPIO_V2_LINE_FLAG_INPUT;
  if (kind != EdgeKind::kFalling) flags |= GPIO_V2_LINE_FLAG_EDGE_RISING;
  if (kind != EdgeKind::kRising) flags |= GPIO_V2_LINE_FLAG_EDGE_FALLING;
  return flags;
}

// The node and number of a chip by its name or label. False: there is none.
bool find_chip(const char* name, TextWriter& path, uint8_t& number) {
  constexpr const char* kChip = "gpiochip";
  constexpr size_t kChipSize = 8;
  const auto set = [&](const char* node) {
    path.put("/dev/").put(node);
    number = static_cast<uint8_t>(std::strtoul(node + kChipSize, nullptr, 10));
    return true;
  };
  if (std::strncmp(name, kChip, kChipSize) == 0) return set(name);
  gpiod_chip* const chip = gpiod_chip_open_lookup(name);
  if (chip == nullptr) return false;
  set(gpiod_chip_name(chip));
  gpiod_chip_close(chip);
  return true;
}

}  // namespace

// ---- edges -------------------------------------------------------------------------------------

const char* EdgePins::find(const char* const* names, int count) {
  PIRVS_ASSERT(count >= 1 && count <= kPinsMax);
  close();
  path_[0] = 0;
  char chip[kNameMax] = "";
  for (int i = 0; i < count; ++i) {
    Place place;
    if (!find_place(names[i], place)) return kNoSuchPin;
    if (i > 0 && std::strcmp(chip, place.chip) != 0) {
      return "both pins of an encoder must be of one chip";
    }
    std::memcpy(chip, place.chip, sizeof chip);
    pins_[i].line = static_cast<uint8_t>(place.offset);
  }
  Text<sizeof path_> path;
  uint8_t number = 0;
  if (!find_chip(chip, path, number)) return reason_of_errno();
  if (path.full()) return kNoSuchPin;
  std::memcpy(path_, path.c_str(), path.size() + 1);
  count_ = count;
  for (int i = 0; i < count; ++i) pins_[i].bank = number;
  return nullptr;
}

const char* EdgePins::open(EdgeKind kind, const char* user, const SystemCalls& calls) {
  PIRVS_ASSERT(kind != EdgeKind::kNone);
  close();
  if (path_[0] == 0) return kNoSuchPin;
  calls_ = &calls;
  gpio_v2_line_request request{};
  for (int i = 0; i < count_; ++i) request.offsets[i] = pins_[i].line;
  request.num_lines = static_cast<uint32_t>(count_);
  request.event_buffer_size = kKernelEdges;
  request.config.flags = flags_of(kind);
  std::strncpy(request.consumer, user, sizeof request.consumer - 1);
  const int node = calls_->open(path_);
  if (node < 0) return reason_of_errno();
  const int status = calls_->ioctl(node, GPIO_V2_GET_LINE_IOCTL, &request);
  const char* const reason = status == 0 ? nullptr : reason_of_errno();
  calls_->close(node);
  if (reason != nullptr) return reason;
  fd_ = request.fd;
  fcntl(fd_, F_SETFL, fcntl(fd_, F_GETFL) | O_NONBLOCK);
  return nullptr;
}

void EdgePins::close() {
  if (fd_ >= 0) calls_->close(fd_);
  fd_ = -1;
  here_ = at_ = 0;
  seen_ = 0;
}

// False: there is nothing, or the chip is gone; errno says which.
bool EdgePins::refill() {
  gpio_v2_line_event events[kBatch];
  const ssize_t got = read(fd_, events, sizeof events);
  if (got <= 0) return false;
  here_ = static_cast<int>(static_cast<size_t>(got) / sizeof events[0]);
  at_ = 0;
  for (int i = 0; i < here_; ++i) {
    const gpio_v2_line_event& event = events[i];
    edges_[i].t = static_cast<TimeNs>(event.timestamp_ns);
    edges_[i].pin = {pins_[0].bank, static_cast<uint8_t>(event.offset)};
    edges_[i].level = event.id == GPIO_V2_LINE_EVENT_RISING_EDGE;
    lost_before_[i] = event.seqno - seen_ - 1;
    seen_ = event.seqno;
  }
  return here_ > 0;
}

Status EdgePins::poll(GpioEdge& out) {
  if (fd_ < 0) return Status::kBusFault;
  if (at_ == here_ && !refill()) {
    return errno == EAGAIN || errno == EINTR ? Status::kEmpty : Status::kBusFault;
  }
  out = edges_[at_];
  const uint32_t lost = lost_before_[at_++];
  lost_ += lost;
  return lost == 0 ? Status::kOk : Status::kFull;
}

// ---- outputs -----------------------------------------------------------------------------------

const char* OutputPin::open(const char* name, bool level, const char* user) {
  close();
  Place place;
  if (!find_place(name, place)) return kNoSuchPin;
  chip_ = gpiod_chip_open_lookup(place.chip);
  gpiod_line* const line = chip_ != nullptr ? gpiod_chip_get_line(chip_, place.offset) : nullptr;
  if (line != nullptr && gpiod_line_request_output(line, user, level ? 1 : 0) == 0) {
    line_ = line;
    return nullptr;
  }
  const char* const reason = reason_of_errno();
  close();
  return reason;
}

void OutputPin::close() {
  if (line_ != nullptr) (void)write(false);
  if (chip_ != nullptr) gpiod_chip_close(chip_);  // releases its line
  chip_ = nullptr;
  line_ = nullptr;
}

Status OutputPin::write(bool level) {
  if (line_ == nullptr) return Status::kNotFound;
  return gpiod_line_set_value(line_, level ? 1 : 0) == 0 ? Status::kOk : Status::kBusFault;
}

}  // namespace pirvs::bsp
