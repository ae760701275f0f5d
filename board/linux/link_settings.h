// Keys of the robot's link, `link.NAME` of the device's configuration file; of `pirvs run` those
// that are no wire, too.
//   udp = 192.168.7.2:14550      where the robot listens
//   own_port = 0                 where it sends to; 0: to where ours come from
//   serial = /dev/ttyS1:921600   or /dev/ttyGS0, whose speed means nothing
//   rate_hz = 50                 of poses, 10 to 100
//   frame = local_frd            or local_ned: the world's x axis is said to point north
//   messages = odometry          or vision: VISION_POSITION_ESTIMATE and VISION_SPEED_ESTIMATE
//   system = 1                   the vehicle's number, 1 to 255
//   mounting_deg = 0 0 0         roll, pitch, yaw of the IMU's axes in the vehicle's forward, left,
//                                up
// Errors  nullptr, or what is wrong with the value.
// Source  docs/integration.md.
#pragma once

#include <string_view>

#include "board/linux/setting_text.h"
#include "bsp/api/datagram.h"
#include "modules/link/link.h"

namespace pirvs::board {

struct LinkSettings {
  LinkSetup link;
  bool has_udp = false;
  bsp::Endpoint udp;
  uint16_t own_port = 0;
  SettingText serial;  // without its speed
  int baud = 0;        // 0: as it is set
  bool is_set = false;

  bool is_wanted() const { return has_udp || serial.text[0] != 0; }
};

const char* set_link_setting(LinkSettings& settings, std::string_view name, std::string_view value);

}  // namespace pirvs::board
