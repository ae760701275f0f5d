#include "tools/run/robot_output.h"

#include <arpa/inet.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "bsp/replay/sensors.h"
#include "core/config/key_values.h"
#include "tools/dataset/input_error.h"
#include "tools/network/resolve.h"

namespace pirvs::tools {
namespace {

constexpr const char* kUdp = "udp:";

// Of the newest frame: the clock where nothing else is one.
std::atomic<TimeNs> frame_t{0};

TimeNs frame_time() { return frame_t; }

bsp::Endpoint endpoint(const std::string& device) {
  constexpr const char* kWhatToDo = "say where the robot listens, as udp:127.0.0.1:14550";
  const size_t colon = std::min(device.find(':'), device.size());
  int64_t port = 0;
  if (colon + 1 >= device.size() ||
      !read_whole(std::string_view(device).substr(colon + 1), 1, 65'535, port)) {
    throw InputError("no port", device, kWhatToDo);
  }
  const Addresses found = resolve(device.substr(0, colon), static_cast<int>(port), SOCK_DGRAM);
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof address);
  return {ntohl(address.sin_addr.s_addr), static_cast<uint16_t>(port)};
}

}  // namespace

RobotOutput::RobotOutput(const std::string& where, const std::vector<std::string>& settings,
                         bool real_time)
    : where_(where), real_time_(real_time) {
  for (const std::string& setting : settings) {
    const size_t equals = std::min(setting.find('='), setting.size());
    const std::string value = setting.substr(std::min(equals + 1, setting.size()));
    const char* const why =
        set_link_setting(settings_, std::string_view(setting.data(), equals), value);
    if (why != nullptr) throw InputError(why, "--mavlink-set", setting);
  }
  if (settings_.is_wanted()) {
    throw InputError("udp and serial are a device's", "--mavlink-set", "say --mavlink instead");
  }
  if (where.rfind(kUdp, 0) == 0) {
    settings_.udp = endpoint(where.substr(std::strlen(kUdp)));
    settings_.has_udp = true;
    return;
  }
  file_.open(where, std::ios::binary);
  if (!file_) throw InputError("cannot write", where, "check the folder and its permissions");
}

void RobotOutput::frame(const FrameReport& report) {
  if (report.t > frame_t) frame_t = report.t;
  to_file_.frame(report.t);
  started_ = true;
}

void RobotOutput::health(TimeNs, HealthState state, const char* what) {
  wire_.health(state, what);
  if (to_file_.is_open()) to_file_.link().health(state, what);
}

void RobotOutput::answer(const Answer& answer) { wire_.answer(answer); }

void RobotOutput::open(App& app, const ImuNoise& noise) {
  frame_t = 0;
  if (settings_.has_udp) {
    const char* const why =
        wire_.open(settings_, noise, app, real_time_ ? bsp::replay_now : frame_time);
    if (why != nullptr) throw InputError(why, where_, "take fewer outputs");
    return;
  }
  const auto send = [](void* self, const uint8_t* frame, size_t size) {
    auto& output = *static_cast<RobotOutput*>(self);
    const auto usec = static_cast<uint64_t>(output.to_file_.now()) / 1000;
    char stamp[8];
    for (int i = 0; i < 8; ++i) stamp[i] = static_cast<char>(usec >> (56 - 8 * i) & 0xFF);
    output.file_.write(stamp, sizeof stamp);
    output.file_.write(reinterpret_cast<const char*>(frame), static_cast<std::streamsize>(size));
    return output.file_.good();
  };
  const Status status = to_file_.open(settings_.link, noise, {}, {this, send}, app.poses());
  if (status != Status::kOk) throw InputError("too many take poses", where_, "take fewer outputs");
}

// The clock of a recording in real time is known once it plays.
void RobotOutput::after_step() {
  if (to_file_.is_open()) return to_file_.poll();
  if (!started_) return;
  if (!real_time_) return wire_.poll();
  if (!wire_.runs() && fault_ == nullptr) fault_ = wire_.start_thread();
}

void RobotOutput::close() {
  if (to_file_.is_open()) {
    to_file_.close();
    file_.close();
    if (!file_) throw InputError("cannot write", where_, "check the space");
  }
  wire_.close();
  if (fault_ != nullptr) throw InputError(fault_, where_, "close other programs");
}

void RobotOutput::add_counters(std::vector<Count>& out) const {
  const auto add = [&out](const char* name, uint32_t value) {
    out.push_back({std::string("link.") + name, value});
  };
  if (settings_.has_udp) return wire_.for_each_counter(add);
  for_each_counter(to_file_.link().counters(), kLinkRows, add);
}

}  // namespace pirvs::tools
