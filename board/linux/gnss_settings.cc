#include "board/linux/gnss_settings.h"

#include "board/linux/endpoint_text.h"
#include "board/linux/serial_text.h"
#include "core/config/key_values.h"

namespace pirvs::board {
namespace {

const char* read_receiver(std::string_view value, GnssSettings& out) {
  const std::string_view endpoint = behind(value, "udp:");
  if (endpoint.empty()) return read_serial(value, out.serial, out.baud);
  const char* const why = read_endpoint(endpoint, out.udp);
  if (why == nullptr) out.has_udp = true;
  return why;
}

const char* read_milliseconds(std::string_view value, double min, TimeNs& out) {
  constexpr double kMax = 1000;
  double ms = 0;
  if (!read_numbers(value, &ms, 1) || ms < min || ms > kMax) return "not a time below 1000 ms";
  out = from_seconds(ms * 1e-3);
  return nullptr;
}

const char* read_latency(std::string_view value, GnssSettings& out) {
  return read_milliseconds(value, 0, out.latency_ns);
}

const char* read_antenna(std::string_view value, GnssSettings& out) {
  double p[3];
  if (!read_numbers(value, p, 3)) return "x, y and z in metres, as 0 0 0.1";
  out.antenna.p_BA = Vec3(p[0], p[1], p[2]);
  out.has_antenna = true;
  return nullptr;
}

const char* read_time_offset(std::string_view value, GnssSettings& out) {
  out.has_time_offset = true;
  return read_milliseconds(value, -1000, out.antenna.time_offset_ns);
}

constexpr SettingKey<GnssSettings> kKeys[] = {
    {"", read_receiver},
    {"latency_ms", read_latency},
    {"antenna_m", read_antenna},
    {"time_offset_ms", read_time_offset},
};

}  // namespace

const char* set_gnss_setting(GnssSettings& settings, std::string_view name,
                             std::string_view value) {
  return read_key(kKeys, name, value, settings);
}

void put_antenna(const GnssSettings& settings, GnssAntenna& out) {
  if (settings.has_antenna) out.p_BA = settings.antenna.p_BA;
  if (settings.has_time_offset) out.time_offset_ns = settings.antenna.time_offset_ns;
}

}  // namespace pirvs::board
