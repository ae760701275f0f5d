#include "board/linux/link_settings.h"

#include <gtest/gtest.h>

#include <string>

#include "board/linux/settings.h"
#include "core/math/trig.h"

namespace pirvs::board {
namespace {

constexpr const char* kWhole =
    "calibration = calibration.cfg\n"
    "camera.left = /dev/video0\n"
    "imu = iio:0\n";

TEST(LinkSettings, ReadsAllKeys) {
  Settings out;
  ASSERT_FALSE(read_settings(std::string(kWhole) + "link.udp = 192.168.7.2:14550\n"
                                                   "link.own_port = 14540\n"
                                                   "link.serial = /dev/ttyS1:921600\n"
                                                   "link.rate_hz = 30\n"
                                                   "link.frame = local_ned\n"
                                                   "link.messages = vision\n"
                                                   "link.system = 42\n"
                                                   "link.mounting_deg = 0 -90 180\n",
                             out));
  EXPECT_FALSE(find_missing(out));
  const LinkSettings& link = out.link;
  EXPECT_TRUE(link.is_wanted());
  EXPECT_EQ(link.udp.address, 0xC0A8'0702u);
  EXPECT_EQ(link.udp.port, 14'550);
  EXPECT_EQ(link.own_port, 14'540);
  EXPECT_STREQ(link.serial.text, "/dev/ttyS1");
  EXPECT_EQ(link.baud, 921'600);
  EXPECT_EQ(link.link.rate_hz, 30);
  EXPECT_EQ(link.link.frame, LinkFrame::kLocalNed);
  EXPECT_EQ(link.link.messages, LinkMessages::kVision);
  EXPECT_EQ(link.link.system, 42);
  EXPECT_DOUBLE_EQ(link.link.mounting_rad.y(), -kPi / 2);
}

TEST(LinkSettings, ATtyOfTheUsbGadgetHasNoSpeed) {
  LinkSettings out;
  ASSERT_EQ(set_link_setting(out, "serial", "/dev/ttyGS0"), nullptr);
  EXPECT_STREQ(out.serial.text, "/dev/ttyGS0");
  EXPECT_EQ(out.baud, 0);
}

TEST(LinkSettings, WhatCannotBeIsSaidWithItsLine) {
  const struct {
    const char *line, *what;
  } broken[] = {
      {"link.upd = 1.2.3.4:5", "no such key"},
      {"link.udp = autopilot:14550", "not an address and a port, as 192.168.7.2:14550"},
      {"link.own_port = 65536", "not a port"},
      {"link.serial = :921600", "a tty and its speed, as /dev/ttyS1:921600"},
      {"link.serial = /dev/ttyS1:123",
       "no speed of a serial line behind the colon, as 115200, 460800, 921600"},
      {"link.serial = /dev/ttyS1:",
       "no speed of a serial line behind the colon, as 115200, 460800, 921600"},
      {"link.rate_hz = 5", "not a rate from 10 to 100 Hz"},
      {"link.rate_hz = nan", "not a rate from 10 to 100 Hz"},
      {"link.frame = ned", "local_frd or local_ned"},
      {"link.messages = both", "odometry or vision"},
      {"link.system = 0", "a vehicle's number is 1 to 255"},
      {"link.mounting_deg = 0 0", "roll, pitch and yaw in degrees, as 0 0 90"},
      {"link.mounting_deg = 0 0 400", "roll, pitch and yaw in degrees, as 0 0 90"},
  };
  for (const auto& one : broken) {
    Settings out;
    const std::string text = kWhole + std::string(one.line) + "\n";
    const ConfigFault fault = read_settings(text, out);
    ASSERT_TRUE(fault) << one.line;
    EXPECT_EQ(fault.line, 4) << one.line;
    EXPECT_STREQ(fault.what, one.what) << one.line;
  }
}

TEST(LinkSettings, ALinkNeedsAWireOfItsOwn) {
  Settings out;
  ASSERT_FALSE(read_settings(std::string(kWhole) + "link.rate_hz = 30\n", out));
  EXPECT_EQ(find_missing(out).key, "link.udp or link.serial");
  ASSERT_EQ(set_setting(out, "link.serial", "/dev/ttyGS0"), nullptr);
  EXPECT_FALSE(find_missing(out));
  ASSERT_EQ(set_setting(out, "output.serial", "/dev/ttyGS0"), nullptr);
  EXPECT_EQ(find_missing(out).key, "link.serial");
}

}  // namespace
}  // namespace pirvs::board
