#include "board/linux/link_settings.h"

#include "board/linux/endpoint_text.h"
#include "board/linux/serial_text.h"
#include "core/config/key_values.h"
#include "core/math/trig.h"

namespace pirvs::board {
namespace {

const char* read_udp(std::string_view value, LinkSettings& out) {
  const char* const why = read_endpoint(value, out.udp);
  if (why == nullptr) out.has_udp = true;
  return why;
}

const char* read_own_port(std::string_view value, LinkSettings& out) {
  int64_t port = 0;
  if (!read_whole(value, 0, 65'535, port)) return "not a port";
  out.own_port = static_cast<uint16_t>(port);
  return nullptr;
}

const char* read_wire(std::string_view value, LinkSettings& out) {
  return read_serial(value, out.serial, out.baud);
}

const char* read_rate(std::string_view value, LinkSettings& out) {
  double rate_hz = 0;
  if (!read_numbers(value, &rate_hz, 1) || rate_hz < LinkSetup::kRateMin_hz ||
      rate_hz > LinkSetup::kRateMax_hz) {
    return "not a rate from 10 to 100 Hz";
  }
  out.link.rate_hz = rate_hz;
  return nullptr;
}

const char* read_frame(std::string_view value, LinkSettings& out) {
  const bool ned = value == "local_ned";
  if (!ned && value != "local_frd") return "local_frd or local_ned";
  out.link.frame = ned ? LinkFrame::kLocalNed : LinkFrame::kLocalFrd;
  return nullptr;
}

const char* read_messages(std::string_view value, LinkSettings& out) {
  const bool vision = value == "vision";
  if (!vision && value != "odometry") return "odometry or vision";
  out.link.messages = vision ? LinkMessages::kVision : LinkMessages::kOdometry;
  return nullptr;
}

const char* read_system(std::string_view value, LinkSettings& out) {
  int64_t system = 0;
  if (!read_whole(value, 1, 255, system)) return "a vehicle's number is 1 to 255";
  out.link.system = static_cast<int>(system);
  return nullptr;
}

const char* read_mounting(std::string_view value, LinkSettings& out) {
  double angles_deg[3];
  bool good = read_numbers(value, angles_deg, 3);
  for (int i = 0; good && i < 3; ++i) good = angles_deg[i] >= -360 && angles_deg[i] <= 360;
  if (!good) return "roll, pitch and yaw in degrees, as 0 0 90";
  for (int i = 0; i < 3; ++i) out.link.mounting_rad(i) = angles_deg[i] * (kPi / 180);
  return nullptr;
}

constexpr SettingKey<LinkSettings> kKeys[] = {
    {"udp", read_udp},       {"own_port", read_own_port},     {"serial", read_wire},
    {"rate_hz", read_rate},  {"frame", read_frame},           {"messages", read_messages},
    {"system", read_system}, {"mounting_deg", read_mounting},
};

}  // namespace

const char* set_link_setting(LinkSettings& settings, std::string_view name,
                             std::string_view value) {
  return read_key(kKeys, name, value, settings);
}

}  // namespace pirvs::board
