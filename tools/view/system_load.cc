#include "tools/view/system_load.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "bsp/api/clock.h"
#include "tools/view/message.h"

namespace pirvs::tools {

using nlohmann::json;

namespace {

double process_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Of all zones that can be read.
json temperature() {
  json hottest = nullptr;
  std::error_code error;
  for (const auto& zone : std::filesystem::directory_iterator("/sys/class/thermal", error)) {
    double milli = 0;
    std::ifstream file(zone.path() / "temp");
    if (!(file >> milli)) continue;
    const double degrees = milli / 1000;
    if (hottest.is_null() || degrees > hottest.get<double>()) hottest = degrees;
  }
  return hottest;
}

json memory_mb() {
  size_t all = 0, resident = 0;
  std::ifstream file("/proc/self/statm");
  if (!(file >> all >> resident)) return nullptr;
  return double(resident) * double(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace

json SystemLoad::measure() {
  const TimeNs now = bsp::now();
  const double used_s = process_seconds();
  double busy = 0, all = 0;
  std::string cpu;
  std::ifstream stat("/proc/stat");
  stat >> cpu;
  constexpr int kIdle = 3, kWaiting = 4, kColumns = 8;
  for (int i = 0; i < kColumns; ++i) {
    double ticks = 0;
    stat >> ticks;
    all += ticks;
    if (i != kIdle && i != kWaiting) busy += ticks;
  }
  json out = {{"cpu", nullptr},
              {"machine", nullptr},
              {"cores", std::max(1U, std::thread::hardware_concurrency())},
              {"memory_mb", memory_mb()},
              {"temperature", temperature()}};
  if (t_ != 0 && now > t_) out["cpu"] = view_number((used_s - used_s_) / to_seconds(now - t_));
  if (t_ != 0 && all > machine_all_) {
    out["machine"] = view_number((busy - machine_busy_) / (all - machine_all_));
  }
  t_ = now;
  used_s_ = used_s;
  machine_busy_ = busy;
  machine_all_ = all;
  return out;
}

}  // namespace pirvs::tools
