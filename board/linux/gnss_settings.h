// Keys of a GNSS receiver, `gnss` and `gnss.NAME` of the device's configuration file.
//   gnss = /dev/ttyS4:115200     a serial line and its speed; or udp:192.168.7.1:5000, where to
//                                listen for its bytes as datagrams
//   gnss.latency_ms = 80         from a fix to its first byte, for receivers without a pulse
//   gnss.antenna_m = 0 0 0.1     where it sits, in B; instead of the calibration's
//   gnss.time_offset_ms = 0      added to the fixes' stamps; likewise
// Errors  nullptr, or what is wrong with the value.
// Source  docs/gnss.md.
#pragma once

#include <string_view>

#include "board/linux/setting_text.h"
#include "bsp/api/datagram.h"
#include "modules/calibration/calibration.h"
#include "modules/gnss/receiver_clock.h"

namespace pirvs::board {

struct GnssSettings {
  SettingText serial;  // without its speed
  int baud = 0;        // 0: as it is set
  bool has_udp = false;
  bsp::Endpoint udp;
  TimeNs latency_ns = ReceiverClock::kLatency_ns;
  bool has_antenna = false, has_time_offset = false;
  GnssAntenna antenna;
  bool is_set = false;

  bool is_wanted() const { return has_udp || serial.text[0] != 0; }
};

// `name`: what stands behind `gnss.`, or nothing.
const char* set_gnss_setting(GnssSettings& settings, std::string_view name, std::string_view value);

// What the settings say better than the calibration.
void put_antenna(const GnssSettings& settings, GnssAntenna& out);

}  // namespace pirvs::board
