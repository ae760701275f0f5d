// The device's configuration file, plain `key = value` (core/config/key_values.h).
// In      Its text.
// Out     What is set, defaults else. Keys:
//           calibration = calibration.cfg        needed; `pirvs calibration` writes it
//           camera.left = /dev/video0            needed; isp:0, isp:1 by the board's table
//           camera.right = /dev/video2           needed with a calibration of two cameras
//           camera.pairing = trigger             or stamp: free-running cameras
//           camera.pair_ms = 1                   how far the stamps of one trigger may differ
//           camera.period_ms = 50                nominal, for pairing by stamp
//           camera.format = any                  or a code of V4L2: GREY, YUYV, RGGB, MJPG (pc) ...
//           camera.range = driver                or full, limited: what black and white are
//           camera.clock = monotonic             or boottime: of the driver's stamps
//           camera.stamp = driver                as its flags say; exposure_start, frame_end
//           camera.exposure = auto               ours, of both; camera: its own; or microseconds
//           camera.gain = auto                   or a factor
//           camera.gain_one = 0                  code of factor 1; 0: the control's least, above 0
//           camera.control_delay = 2             images until a command is true
//           camera.left_sensor = /dev/v4l-subdev1    who has the controls; right_sensor likewise
//           camera.exposure_us = 0               for stamps; 0: the camera's control says it
//           camera.readout_us = 0                end of exposure to end of frame
//           camera.left_events = /dev/v4l-subdev0    who sends FRAME_SYNC; right_events likewise
//           trigger = none                       or pwm:CHIP.CHANNEL, of /sys/class/pwm
//           trigger.rate_hz = 60                 needed with a trigger, by a PWM or a pin
//           trigger.width_us = 1000
//           imu = iio:0                          needed: number or name, iio:mpu6500; or
//                                                icm20602:BUS or BUS:ADDRESS, icm20602:1:69
//           imu.data_ready = HEADER_13           its interrupt's pin, for icm20602
//           imu.rate_hz = 200                    of iio; icm20602 has 200
//           imu.delay_us = 0                     of the chip's filter, taken off the stamp
//           output.text = poses                  or frames, none: lines on standard output
//           output.poses = 192.168.7.2:14550     the same lines as datagrams, at IMU rate
//           output.serial = /dev/ttyGS0          the same lines, and commands (text_commands.h)
//           output.images = /run/pirvs/images    to one other program that asks (image_share.h)
//           gnss = /dev/ttyS4:115200             a receiver, or udp:...; gnss.NAME = VALUE
//                                                (board/linux/gnss_settings.h)
//           link.NAME = VALUE                    to an autopilot (board/linux/link_settings.h)
//           usb.NAME = VALUE                     pirvs-usb's (board/usb/usb_settings.h)
//           output.stream = 192.168.7.1:14560    where to listen for those who want the stream;
//                                                127.0.0.1: programs of this machine
//           pin.health = gpiochip2:11            high while tracking is good; or a line's name
//           pin.health_confidence = 0.3          and its confidence is no lower
//           pin.trigger = HEADER_15              drives the cameras, centred; instead of a PWM
//           pin.sync_out = HEADER_7              a pulse at the middle of each exposure
//           pin.sync_out_us = 500                its width
//           pin.sync_in = HEADER_11              edges given out with the pose at their time
//           pin.sync_in_edge = rising            falling or both
//           pin.sync_in_as = event               or pps: a pulse per second
//           pin.wheel_left = PIN_A, PIN_B        an encoder; pin.wheel_right likewise
//           record = DIR                         all from the start on, as an ASL folder
//           recordings = DIR                     instead of record: for those by command, and maps
//           map = NAME                           loaded at the start, from the folder of records
//           realtime = yes                       SCHED_FIFO, fixed CPUs, locked memory
//           watchdog = /dev/watchdog0            of the hardware; systemd's needs no setting
//           parameter.GROUP.NAME = VALUE         as pirvs params lists them
// Errors  A fault with its line: unknown or repeated keys, values that cannot be, what is missing.
// Cost    microseconds, at start. No heap.
// Source  docs/device.md.
#pragma once

#include <string_view>

#include "board/linux/gnss_settings.h"
#include "board/linux/link_settings.h"
#include "board/linux/setting_text.h"
#include "board/linux/wiring.h"
#include "bsp/api/datagram.h"
#include "bsp/api/gpio.h"
#include "bsp/linux/i2c_imu.h"
#include "bsp/linux/iio.h"
#include "bsp/linux/v4l2_stereo.h"
#include "core/config/key_values.h"
#include "modules/app/app_params.h"

namespace pirvs::board {

enum class TextOutput : uint8_t { kPoses, kFrames, kNone };

// Roles of the device's pins (board/linux/pins.h); a name that is empty: no such pin.
struct PinSettings {
  SettingText health, trigger, sync_out, sync_in;
  SettingText wheel[2][2];  // left and right, pins A and B
  float health_confidence = 0.3f;
  TimeNs sync_out_width_ns = 500'000;
  bsp::EdgeKind sync_in_edge = bsp::EdgeKind::kRising;
  bool sync_in_is_pps = false;
};

struct Settings {
  SettingText calibration;
  SettingText camera[kCamerasMax], camera_events[kCamerasMax], camera_sensor[kCamerasMax];
  bsp::V4l2StereoSetup stereo;  // without its cameras' paths and sizes
  TriggerSetup trigger;         // without its pin
  bool has_trigger_rate = false;
  SettingText imu;
  bsp::IioSetup iio;  // without its device
  bool imu_is_on_i2c = false;
  bsp::I2cImuSetup i2c_imu;  // without its texts
  SettingText imu_data_ready;
  TextOutput text = TextOutput::kPoses;
  bool has_poses_to = false;
  bsp::Endpoint poses_to;
  SettingText serial, images;
  bool has_stream = false;
  bsp::Endpoint stream;
  LinkSettings link;
  GnssSettings gnss;
  PinSettings pins;
  SettingText record, recordings;
  SettingText map;  // loaded at the start
  bool realtime = true;
  SettingText watchdog;
  AppParams params;
};

inline constexpr size_t kSettingsTextMax = 16'384;

[[nodiscard]] ConfigFault read_settings(std::string_view text, Settings& out);
// One `key=value`, as a line of the file: nullptr, or what is wrong. For the command line.
[[nodiscard]] const char* set_setting(Settings& settings, std::string_view key,
                                      std::string_view value);
// Where recordings and maps go.
const char* folder_of(const Settings& settings);
// Which of the board's ISPs a camera is, -1: a node.
int isp_of(const SettingText& camera);
// What follows from several keys: no exposure outlasts the trigger's period.
void finish_settings(Settings& settings);
// What the file and the command line have left out, and what cannot be together.
[[nodiscard]] ConfigFault find_missing(const Settings& settings);

}  // namespace pirvs::board
