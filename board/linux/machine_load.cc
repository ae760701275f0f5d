#include "board/linux/machine_load.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace pirvs::board {
namespace {

constexpr const char* kZone = "/sys/class/thermal/thermal_zone0/temp";

uint64_t used_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& t) { return t.tv_sec * 1000 + t.tv_usec / 1000; };
  return static_cast<uint64_t>(ms(usage.ru_utime) + ms(usage.ru_stime));
}

}  // namespace

void MachineLoad::open() { zone_fd_ = ::open(kZone, O_RDONLY | O_CLOEXEC); }

void MachineLoad::close() {
  if (zone_fd_ >= 0) ::close(zone_fd_);
  zone_fd_ = -1;
}

// A counter has no sign: frost is 0.
void MachineLoad::for_each_counter(void (*visit)(const char* name, uint64_t value)) const {
  visit("cpu_ms", used_ms());
  char text[24];
  const ssize_t size = zone_fd_ < 0 ? 0 : pread(zone_fd_, text, sizeof text - 1, 0);
  if (size <= 0) return;
  text[size] = 0;
  visit("temperature_mC", static_cast<uint64_t>(std::max(0L, std::strtol(text, nullptr, 10))));
}

}  // namespace pirvs::board
