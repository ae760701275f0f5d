#include "board/linux/settings.h"

#include <gtest/gtest.h>

#include <string>

namespace pirvs::board {
namespace {

constexpr const char* kWhole =
    "calibration = calibration.cfg\n"
    "camera.left = /dev/video0\n"
    "camera.right = /dev/video2\n"
    "imu = iio:mpu6500\n";

TEST(Settings, ReadsAWholeFile) {
  Settings out;
  const std::string text = std::string(kWhole) +
                           "camera.pairing = stamp\n"
                           "camera.clock = boottime\n"
                           "camera.format = YUYV\n"
                           "camera.range = limited\n"
                           "camera.stamp = frame_end\n"
                           "camera.exposure_us = 4000\n"
                           "camera.readout_us = 12500.5\n"
                           "camera.pair_ms = 0.5\n"
                           "camera.left_events = /dev/v4l-subdev3\n"
                           "camera.right_sensor = /dev/v4l-subdev9\n"
                           "camera.exposure = 2500\n"
                           "camera.gain = 1.5\n"
                           "camera.gain_one = 16\n"
                           "camera.control_delay = 3\n"
                           "trigger = pwm:1.0\n"
                           "trigger.rate_hz = 60\n"
                           "trigger.width_us = 500\n"
                           "imu.rate_hz = 500\n"
                           "imu.delay_us = 2900\n"
                           "output.text = frames\n"
                           "output.poses = 192.168.7.2:14550\n"
                           "output.serial = /dev/ttyGS0\n"
                           "output.images = /run/pirvs/images\n"
                           "usb.size = 752 480\n"
                           "record = /tmp/flight\n"
                           "realtime = no\n"
                           "parameter.frontend.tracks_target = 120\n";
  const ConfigFault fault = read_settings(text, out);
  ASSERT_FALSE(fault) << fault.line << ' ' << fault.what;
  EXPECT_FALSE(find_missing(out));
  EXPECT_STREQ(out.calibration.text, "calibration.cfg");
  EXPECT_STREQ(out.camera[1].text, "/dev/video2");
  EXPECT_STREQ(out.camera_events[0].text, "/dev/v4l-subdev3");
  EXPECT_STREQ(out.camera_sensor[1].text, "/dev/v4l-subdev9");
  EXPECT_EQ(out.trigger.pwm_chip, 1);
  EXPECT_EQ(out.trigger.pwm_channel, 0);
  EXPECT_EQ(out.trigger.timing.period_ns, 16'666'667u);
  EXPECT_EQ(out.trigger.timing.width_ns, 500'000u);
  finish_settings(out);
  EXPECT_FLOAT_EQ(out.params.exposure.longest_s, 1 / 60.0f - 0.005f) << "its readout is left";
  EXPECT_FLOAT_EQ(out.params.exposure.exposure_s, 0.0025f);
  EXPECT_EQ(out.params.exposure.gain, 1.5f);
  EXPECT_STREQ(out.imu.text, "iio:mpu6500");
  EXPECT_EQ(out.stereo.pairing, bsp::Pairing::kStamp);
  EXPECT_EQ(out.stereo.pair_ns_max, 500'000);
  for (const auto& camera : out.stereo.camera) {
    EXPECT_EQ(camera.clock, bsp::StampClock::kBoottime);
    EXPECT_EQ(camera.means, bsp::StampMeans::kFrameEnd);
    EXPECT_EQ(camera.format, 0x5659'5559u) << "the first character is the lowest byte";
    EXPECT_EQ(camera.range, bsp::GreyRange::kLimited);
    EXPECT_EQ(camera.exposure_ns, 4'000'000);
    EXPECT_EQ(camera.readout_ns, 12'500'500);
    EXPECT_EQ(camera.controls.gain_one, 16);
    EXPECT_EQ(camera.control_delay, 3);
  }
  EXPECT_EQ(out.iio.rate_hz, 500);
  EXPECT_EQ(out.iio.delay_ns, 2'900'000);
  EXPECT_EQ(out.text, TextOutput::kFrames);
  EXPECT_STREQ(out.serial.text, "/dev/ttyGS0");
  EXPECT_STREQ(out.images.text, "/run/pirvs/images");
  ASSERT_TRUE(out.has_poses_to);
  EXPECT_EQ(out.poses_to.address, 0xc0a8'0702u);
  EXPECT_EQ(out.poses_to.port, 14550);
  EXPECT_STREQ(out.record.text, "/tmp/flight");
  EXPECT_FALSE(out.realtime);
  EXPECT_EQ(out.params.frontend.tracks_target, 120);
}

TEST(Settings, EachBrokenLineIsNamed) {
  struct Broken {
    std::string line;
    const char* what;
  };
  const Broken kBroken[] = {
      {"camera.middle = /dev/video1", "no such key"},
      {"camera.left = /dev/video1", "the key stands there twice"},
      {"camera.pairing = arrival", "trigger or stamp"},
      {"camera.clock = realtime", "monotonic or boottime"},
      {"camera.format = JPEG2", "any, or four characters, as GREY, YUYV or MJPG"},
      {"camera.range = wide", "driver, full or limited"},
      {"camera.stamp = mid", "driver, exposure_start or frame_end"},
      {"camera.exposure_us = -1", "not a time, or too long a one"},
      {"camera.readout_us = 1e9", "not a time, or too long a one"},
      {"trigger = gpio", "none, or pwm: and chip.channel, as pwm:1.0"},
      {"trigger = pwm:1", "none, or pwm: and chip.channel, as pwm:1.0"},
      {"trigger.rate_hz = 0", "not a rate from 1 to 200 Hz"},
      {"trigger.width_us = 1e6", "not a time, or too long a one"},
      {"camera.exposure = bright", "auto, camera, or 10 to 200000 microseconds"},
      {"camera.exposure = 1", "auto, camera, or 10 to 200000 microseconds"},
      {"camera.gain = 0.5", "auto, or a factor from 1 to 64"},
      {"camera.gain_one = -1", "not a code from 0 to 65535"},
      {"camera.control_delay = 2.5", "not a number of images from 0 to 8"},
      {"camera.pair_ms = soon", "not a time, or too long a one"},
      {"imu.rate_hz = 5", "not a rate from 20 to 8000 Hz"},
      {"output.text = yes", "poses, frames or none"},
      {"output.poses = 192.168.7.2", "not an address and a port, as 192.168.7.2:14550"},
      {"output.poses = 192.168.7.256:1", "not an address and a port, as 192.168.7.2:14550"},
      {"output.poses = 192.168.7.2:0", "not an address and a port, as 192.168.7.2:14550"},
      {"output.poses = 1.2.3.4:5:6", "not an address and a port, as 192.168.7.2:14550"},
      {"output.poses = 1.2.3.4.5", "not an address and a port, as 192.168.7.2:14550"},
      {"usb.sise = 640 480", "no such key"},
      {"usb.video = both", "left, right or none"},
      {"realtime = maybe", "yes or no"},
      {"record = " + std::string(96, 'x'), "longer than 95 bytes"},
      {"parameter.no.such = 1", "no such parameter"},
      {"parameter.frontend.tracks_target = many", "not a number"},
      {"parameter.frontend.tracks_target = 1e9", "out of range"},
      {"parameter. = 1", "no such key"},
      {"a line", "not `key = value`"},
  };
  for (const Broken& broken : kBroken) {
    Settings out;
    const std::string text = kWhole + ("\n" + broken.line) + "\n";
    const ConfigFault fault = read_settings(text, out);
    ASSERT_TRUE(fault) << broken.line;
    EXPECT_EQ(fault.line, 6) << broken.line;
    EXPECT_STREQ(fault.what, broken.what) << broken.line;
  }
}

TEST(Settings, SomeFollowFromOthers) {
  Settings out;
  EXPECT_STREQ(set_setting(out, "camera.left", "isp:2"), "an ISP is isp:0 or isp:1");
  ASSERT_EQ(set_setting(out, "camera.left", "isp:1"), nullptr);
  EXPECT_EQ(isp_of(out.camera[0]), 1);
  EXPECT_EQ(isp_of(out.camera[1]), -1);
  ASSERT_EQ(set_setting(out, "trigger", "none"), nullptr);
  finish_settings(out);
  EXPECT_EQ(out.params.exposure.longest_s, ExposureParams{}.longest_s) << "nobody triggers here";
  ASSERT_EQ(set_setting(out, "camera.exposure", "camera"), nullptr);
  EXPECT_EQ(out.params.exposure.automatic, 0);
  ASSERT_EQ(set_setting(out, "camera.exposure", "auto"), nullptr);
  EXPECT_EQ(out.params.exposure.automatic, 1);
  EXPECT_STREQ(set_setting(out, "imu", "/dev/iio:device0"),
               "an IMU is iio: and its number or name, or icm20602:BUS[:ADDRESS]");
  EXPECT_STREQ(set_setting(out, "imu", "icm20602:1:70"),
               "an ICM-20602 is at 68 or 69 (hexadecimal)");
  ASSERT_EQ(set_setting(out, "imu", "icm20602:1:69"), nullptr);
  EXPECT_EQ(out.i2c_imu.bus, 1);
  EXPECT_EQ(out.i2c_imu.address, 0x69);
  ASSERT_EQ(set_setting(out, "calibration", "c"), nullptr);
  ASSERT_EQ(set_setting(out, "camera.left", "/dev/video0"), nullptr);
  EXPECT_TRUE(find_missing(out)) << "the pin of its interrupt";
  ASSERT_EQ(set_setting(out, "imu.data_ready", "gpiochip0:5"), nullptr);
  EXPECT_FALSE(find_missing(out));
  EXPECT_STREQ(set_setting(out, "pin.wheel_left", "A"), "an encoder has two pins, A and B");
  EXPECT_STREQ(set_setting(out, "pin.sync_in_edge", "up"), "rising, falling or both");
  EXPECT_STREQ(set_setting(out, "pin.sync_in_as", "clock"), "event or pps");
  EXPECT_STREQ(set_setting(out, "pin.health_confidence", "2"), "not from 0 to 1");
  EXPECT_STREQ(set_setting(out, "output.stream", "usb0"),
               "not an address and a port, as 192.168.7.2:14550");
}

TEST(Settings, ATriggerIsAPinOrAPwmAndHasARate) {
  struct Case {
    const char *lines, *key;
  };
  const Case cases[] = {
      {"pin.trigger = TRIGGER\ntrigger.rate_hz = 60\n", nullptr},
      {"trigger = pwm:0.0\ntrigger.rate_hz = 60\n", nullptr},
      {"trigger.rate_hz = 60\n", nullptr},
      {"pin.trigger = TRIGGER\ntrigger = none\ntrigger.rate_hz = 60\n", nullptr},
      {"pin.trigger = TRIGGER\ntrigger = pwm:0.0\ntrigger.rate_hz = 60\n", "pin.trigger"},
      {"pin.trigger = TRIGGER\n", "trigger.rate_hz"},
      {"trigger = pwm:0.0\n", "trigger.rate_hz"},
      {"pin.trigger = TRIGGER\ntrigger.rate_hz = 60\ntrigger.width_us = 8400\n",
       "trigger.width_us"},
      {"pin.trigger = TRIGGER\ntrigger.rate_hz = 60\ntrigger.width_us = 0\n", "trigger.width_us"},
  };
  for (const Case& c : cases) {
    Settings out;
    ASSERT_FALSE(read_settings(kWhole + std::string(c.lines), out)) << c.lines;
    const ConfigFault fault = find_missing(out);
    EXPECT_EQ(static_cast<bool>(fault), c.key != nullptr) << c.lines;
    EXPECT_EQ(fault.key, c.key != nullptr ? c.key : "") << c.lines;
  }
  Settings out;
  ASSERT_EQ(set_setting(out, "pin.trigger", "TRIGGER"), nullptr);
  ASSERT_EQ(set_setting(out, "trigger.rate_hz", "100"), nullptr);
  finish_settings(out);
  EXPECT_FLOAT_EQ(out.params.exposure.longest_s, 0.005f) << "its period without the readout";
}

TEST(Settings, RecordingsHaveOneFolderAndMayWaitForACommand) {
  Settings out;
  ASSERT_FALSE(read_settings(kWhole, out));
  EXPECT_STREQ(folder_of(out), ".");
  ASSERT_EQ(set_setting(out, "recordings", "/recordings"), nullptr);
  EXPECT_STREQ(folder_of(out), "/recordings");
  EXPECT_STREQ(out.record.text, "") << "nothing starts by itself";
  EXPECT_FALSE(find_missing(out));
  ASSERT_EQ(set_setting(out, "record", "/tmp/flight"), nullptr);
  EXPECT_EQ(find_missing(out).key, "recordings");
  out.recordings = {};
  EXPECT_FALSE(find_missing(out));
  EXPECT_STREQ(folder_of(out), "/tmp/flight");
}

TEST(Settings, WhatIsMissingIsNamed) {
  Settings out;
  ASSERT_FALSE(read_settings("camera.left = /dev/video0\ncalibration = c.cfg\n", out));
  EXPECT_EQ(find_missing(out).key, "imu");
}

TEST(Settings, AReceiverOfGnss) {
  const std::string whole =
      "calibration = calibration.cfg\ncamera.left = /dev/video0\nimu = iio:0\n";
  Settings out;
  ASSERT_FALSE(read_settings(whole + "gnss = /dev/ttyS4:115200\ngnss.latency_ms = 50\n"
                                     "gnss.antenna_m = 0.1 0 -0.2\ngnss.time_offset_ms = -3\n",
                             out));
  EXPECT_FALSE(find_missing(out));
  EXPECT_STREQ(out.gnss.serial.text, "/dev/ttyS4");
  EXPECT_EQ(out.gnss.baud, 115'200);
  EXPECT_EQ(out.gnss.latency_ns, 50'000'000);
  GnssAntenna antenna;
  put_antenna(out.gnss, antenna);
  EXPECT_EQ(antenna.p_BA, Vec3(0.1, 0, -0.2));
  EXPECT_EQ(antenna.time_offset_ns, -3'000'000);
  for (const char* wrong : {"gnss = /dev/ttyS4:fast", "gnss = udp:here", "gnss.latency_ms = -1",
                            "gnss.antenna_m = 1", "gnss.time_offset_ms = 2000", "gnss.rate = 5"}) {
    Settings bad;
    EXPECT_TRUE(read_settings(wrong, bad)) << wrong;
  }
  Settings alone;
  ASSERT_FALSE(read_settings(whole + "gnss.latency_ms = 50\n", alone));
  EXPECT_STREQ(find_missing(alone).what, "a receiver needs a line");
  Settings twice;
  ASSERT_FALSE(read_settings(whole + "gnss = /dev/ttyS1\nlink.serial = /dev/ttyS1\n", twice));
  EXPECT_STREQ(find_missing(twice).key.data(), "gnss");
}

}  // namespace
}  // namespace pirvs::board
