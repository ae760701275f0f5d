#include "board/linux/settings.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "board/linux/endpoint_text.h"
#include "board/linux/link_settings.h"
#include "board/usb/usb_settings.h"
#include "modules/door/command.h"

namespace pirvs::board {
namespace {

constexpr TimeNs kMicro = 1'000, kMilli = 1'000'000;
constexpr std::string_view kParameter = "parameter.", kLink = "link.", kGnss = "gnss.";

template <class Enum>
struct Choice {
  const char* word;
  Enum value;
};
constexpr Choice<bsp::Pairing> kPairings[] = {{"trigger", bsp::Pairing::kTrigger},
                                              {"stamp", bsp::Pairing::kStamp}};
constexpr Choice<bsp::StampClock> kClocks[] = {{"monotonic", bsp::StampClock::kMonotonic},
                                               {"boottime", bsp::StampClock::kBoottime}};
constexpr Choice<bsp::StampMeans> kStamps[] = {{"driver", bsp::StampMeans::kDriver},
                                               {"exposure_start", bsp::StampMeans::kExposureStart},
                                               {"frame_end", bsp::StampMeans::kFrameEnd}};
constexpr Choice<bsp::GreyRange> kRanges[] = {{"driver", bsp::GreyRange::kDriver},
                                              {"full", bsp::GreyRange::kFull},
                                              {"limited", bsp::GreyRange::kLimited}};
constexpr Choice<TextOutput> kOutputs[] = {
    {"poses", TextOutput::kPoses}, {"frames", TextOutput::kFrames}, {"none", TextOutput::kNone}};

constexpr Choice<bsp::EdgeKind> kEdges[] = {{"rising", bsp::EdgeKind::kRising},
                                            {"falling", bsp::EdgeKind::kFalling},
                                            {"both", bsp::EdgeKind::kBoth}};
constexpr Choice<bool> kSyncIns[] = {{"event", false}, {"pps", true}};

// Each reads a value: nullptr, or what is wrong with it.
template <class Enum, size_t N>
bool read_choice(std::string_view value, const Choice<Enum> (&choices)[N], Enum& out) {
  for (const Choice<Enum>& choice : choices) {
    if (value != choice.word) continue;
    out = choice.value;
    return true;
  }
  return false;
}

const char* read_time(std::string_view value, TimeNs unit, TimeNs max, TimeNs& out) {
  double number = 0;
  const bool good = read_numbers(value, &number, 1) && number >= 0 &&
                    number * static_cast<double>(unit) <= static_cast<double>(max);
  if (!good) return "not a time, or too long a one";
  out = from_seconds(number * to_seconds(unit));
  return nullptr;
}

const char* read_pairing(std::string_view value, Settings& out) {
  return read_choice(value, kPairings, out.stereo.pairing) ? nullptr : "trigger or stamp";
}

const char* read_output(std::string_view value, Settings& out) {
  return read_choice(value, kOutputs, out.text) ? nullptr : "poses, frames or none";
}

// What both cameras have alike.
template <class Enum, size_t N>
bool read_choice_of_both(std::string_view value, const Choice<Enum> (&choices)[N],
                         Enum bsp::V4l2Setup::*field, Settings& out) {
  bool good = true;
  for (auto& camera : out.stereo.camera) good &= read_choice(value, choices, camera.*field);
  return good;
}

const char* read_clock(std::string_view value, Settings& out) {
  const bool good = read_choice_of_both(value, kClocks, &bsp::V4l2Setup::clock, out);
  return good ? nullptr : "monotonic or boottime";
}

const char* read_stamp(std::string_view value, Settings& out) {
  const bool good = read_choice_of_both(value, kStamps, &bsp::V4l2Setup::means, out);
  return good ? nullptr : "driver, exposure_start or frame_end";
}

const char* read_range(std::string_view value, Settings& out) {
  const bool good = read_choice_of_both(value, kRanges, &bsp::V4l2Setup::range, out);
  return good ? nullptr : "driver, full or limited";
}

// As V4L2 codes it, four characters, or any.
const char* read_format(std::string_view value, Settings& out) {
  uint32_t code = 0;
  if (value != "any" && value.size() != 4) return "any, or four characters, as GREY, YUYV or MJPG";
  for (size_t i = 0; value != "any" && i < 4; ++i) {
    code |= static_cast<uint32_t>(static_cast<uint8_t>(value[i])) << 8 * i;
  }
  for (auto& camera : out.stereo.camera) camera.format = code;
  return nullptr;
}

const char* read_time_of_both(std::string_view value, TimeNs bsp::V4l2Setup::*field,
                              Settings& out) {
  const char* why = nullptr;
  for (auto& camera : out.stereo.camera) {
    why = read_time(value, kMicro, 100 * kMilli, camera.*field);
  }
  return why;
}

const char* read_camera(std::string_view value, SettingText& out) {
  const bool isp = !behind(value, "isp:").empty();
  if (isp && value != "isp:0" && value != "isp:1") return "an ISP is isp:0 or isp:1";
  return read_text(value, out);
}

// pwm:CHIP.CHANNEL
const char* read_trigger(std::string_view value, Settings& out) {
  constexpr const char* kWrong = "none, or pwm: and chip.channel, as pwm:1.0";
  const std::string_view number = behind(value, "pwm:");
  size_t dot = 0;
  while (dot < number.size() && number[dot] != '.') ++dot;
  int64_t chip = -1, channel = 0;
  if (value != "none" &&
      (dot >= number.size() || !read_whole({number.data(), dot}, 0, 63, chip) ||
       !read_whole({number.data() + dot + 1, number.size() - dot - 1}, 0, 63, channel))) {
    return kWrong;
  }
  out.trigger.pwm_chip = static_cast<int>(chip);
  out.trigger.pwm_channel = static_cast<int>(channel);
  return nullptr;
}

const char* read_trigger_rate(std::string_view value, Settings& out) {
  double rate_hz = 0;
  if (!read_numbers(value, &rate_hz, 1) || rate_hz < 1 || rate_hz > 200) {
    return "not a rate from 1 to 200 Hz";
  }
  out.trigger.timing.period_ns = static_cast<uint32_t>(from_seconds(1 / rate_hz));
  out.has_trigger_rate = true;
  return nullptr;
}

const char* read_trigger_width(std::string_view value, Settings& out) {
  TimeNs width = 0;
  const char* const why = read_time(value, kMicro, 100 * kMilli, width);
  if (why == nullptr) out.trigger.timing.width_ns = static_cast<uint32_t>(width);
  return why;
}

// auto, camera, or microseconds.
const char* read_exposure(std::string_view value, Settings& out) {
  ExposureParams& exposure = out.params.exposure;
  double us = 0;
  const bool word = value == "auto" || value == "camera";
  if (!word && (!read_numbers(value, &us, 1) || us < 10 || us > 200e3)) {
    return "auto, camera, or 10 to 200000 microseconds";
  }
  exposure.automatic = value == "camera" ? 0 : 1;
  exposure.exposure_s = static_cast<float>(1e-6 * us);
  return nullptr;
}

const char* read_gain(std::string_view value, Settings& out) {
  double gain = 0;
  if (value != "auto" && (!read_numbers(value, &gain, 1) || gain < 1 || gain > 64)) {
    return "auto, or a factor from 1 to 64";
  }
  out.params.exposure.gain = static_cast<float>(gain);
  return nullptr;
}

const char* read_gain_one(std::string_view value, Settings& out) {
  int64_t code = 0;
  if (!read_whole(value, 0, 65'535, code)) return "not a code from 0 to 65535";
  for (auto& camera : out.stereo.camera) camera.controls.gain_one = static_cast<int>(code);
  return nullptr;
}

const char* read_delay(std::string_view value, Settings& out) {
  int64_t images = 0;
  if (!read_whole(value, 0, 8, images)) return "not a number of images from 0 to 8";
  for (auto& camera : out.stereo.camera) camera.control_delay = static_cast<int>(images);
  return nullptr;
}

const char* read_poses_to(std::string_view value, Settings& out) {
  out.has_poses_to = true;
  return read_endpoint(value, out.poses_to);
}

const char* read_stream(std::string_view value, Settings& out) {
  out.has_stream = true;
  return read_endpoint(value, out.stream);
}

const char* read_rate(std::string_view value, Settings& out) {
  double rate_hz = 0;
  if (!read_numbers(value, &rate_hz, 1) || rate_hz < 20 || rate_hz > 8000) {
    return "not a rate from 20 to 8000 Hz";
  }
  out.iio.rate_hz = rate_hz;
  return nullptr;
}

const char* read_imu(std::string_view value, Settings& out) {
  if (!behind(value, "iio:").empty()) {
    out.imu_is_on_i2c = false;
    return read_text(value, out.imu);
  }
  constexpr const char* kWrong = "an IMU is iio: and its number or name, or icm20602:BUS[:ADDRESS]";
  std::string_view bus = behind(value, "icm20602:");
  const size_t colon = bus.find(':');
  if (colon != std::string_view::npos) {
    // As i2cdetect shows it.
    const std::string_view address(bus.data() + colon + 1, bus.size() - colon - 1);
    if (address != "68" && address != "69") return "an ICM-20602 is at 68 or 69 (hexadecimal)";
    out.i2c_imu.address = address == "69" ? 0x69 : 0x68;
    bus = {bus.data(), colon};
  }
  int64_t number = 0;
  if (!read_whole(bus, 0, 255, number)) return kWrong;
  out.i2c_imu.bus = static_cast<int>(number);
  out.imu_is_on_i2c = true;
  return read_text(value, out.imu);
}

const char* read_imu_delay(std::string_view value, Settings& out) {
  const char* const why = read_time(value, kMicro, 100 * kMilli, out.iio.delay_ns);
  out.i2c_imu.delay_ns = out.iio.delay_ns;
  return why;
}

const char* read_sync_in_edge(std::string_view value, Settings& out) {
  return read_choice(value, kEdges, out.pins.sync_in_edge) ? nullptr : "rising, falling or both";
}

const char* read_sync_in_as(std::string_view value, Settings& out) {
  return read_choice(value, kSyncIns, out.pins.sync_in_is_pps) ? nullptr : "event or pps";
}

const char* read_map_name(std::string_view value, Settings& out) {
  const bool name = value.size() < Command::kTextMax && value.find('/') == value.npos;
  return name ? read_text(value, out.map)
              : "a name in the folder of records, of 63 letters at most";
}

const char* read_confidence(std::string_view value, Settings& out) {
  double number = 0;
  if (!read_numbers(value, &number, 1) || number < 0 || number > 1) return "not from 0 to 1";
  out.pins.health_confidence = static_cast<float>(number);
  return nullptr;
}

const char* read_encoder(std::string_view value, SettingText (&out)[2]) {
  std::string_view names[2];
  if (!read_words(value, names, 2)) return "an encoder has two pins, A and B";
  const char* const why = read_text(names[0], out[0]);
  return why != nullptr ? why : read_text(names[1], out[1]);
}

struct Key {
  const char* name;
  const char* (*read)(std::string_view, Settings&);
};
constexpr Key kKeys[] = {
    {"calibration",
     [](std::string_view v, Settings& out) { return read_text(v, out.calibration); }},
    {"camera.left",
     [](std::string_view v, Settings& out) { return read_camera(v, out.camera[0]); }},
    {"camera.right",
     [](std::string_view v, Settings& out) { return read_camera(v, out.camera[1]); }},
    {"trigger", read_trigger},
    {"trigger.rate_hz", read_trigger_rate},
    {"trigger.width_us", read_trigger_width},
    {"camera.left_events",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_events[0]); }},
    {"camera.right_events",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_events[1]); }},
    {"camera.left_sensor",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_sensor[0]); }},
    {"camera.right_sensor",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_sensor[1]); }},
    {"camera.exposure", read_exposure},
    {"camera.gain", read_gain},
    {"camera.gain_one", read_gain_one},
    {"camera.control_delay", read_delay},
    {"camera.pairing", read_pairing},
    {"camera.format", read_format},
    {"camera.range", read_range},
    {"camera.clock", read_clock},
    {"camera.stamp", read_stamp},
    {"camera.exposure_us",
     [](std::string_view v, Settings& out) {
       return read_time_of_both(v, &bsp::V4l2Setup::exposure_ns, out);
     }},
    {"camera.readout_us",
     [](std::string_view v, Settings& out) {
       return read_time_of_both(v, &bsp::V4l2Setup::readout_ns, out);
     }},
    {"camera.pair_ms",
     [](std::string_view v, Settings& out) {
       return read_time(v, kMilli, 100 * kMilli, out.stereo.pair_ns_max);
     }},
    {"camera.period_ms",
     [](std::string_view v, Settings& out) {
       return read_time(v, kMilli, 1000 * kMilli, out.stereo.period_ns);
     }},
    {"imu", read_imu},
    {"imu.rate_hz", read_rate},
    {"imu.delay_us", read_imu_delay},
    {"imu.data_ready",
     [](std::string_view v, Settings& out) { return read_text(v, out.imu_data_ready); }},
    {"output.text", read_output},
    {"output.poses", read_poses_to},
    {"output.stream", read_stream},
    {"output.serial", [](std::string_view v, Settings& out) { return read_text(v, out.serial); }},
    {"output.images", [](std::string_view v, Settings& out) { return read_text(v, out.images); }},
    {"pin.health", [](std::string_view v, Settings& out) { return read_text(v, out.pins.health); }},
    {"pin.health_confidence", read_confidence},
    {"pin.trigger",
     [](std::string_view v, Settings& out) { return read_text(v, out.pins.trigger); }},
    {"pin.sync_out",
     [](std::string_view v, Settings& out) { return read_text(v, out.pins.sync_out); }},
    {"pin.sync_out_us",
     [](std::string_view v, Settings& out) {
       return read_time(v, kMicro, 10 * kMilli, out.pins.sync_out_width_ns);
     }},
    {"pin.sync_in",
     [](std::string_view v, Settings& out) { return read_text(v, out.pins.sync_in); }},
    {"pin.sync_in_edge", read_sync_in_edge},
    {"pin.sync_in_as", read_sync_in_as},
    {"pin.wheel_left",
     [](std::string_view v, Settings& out) { return read_encoder(v, out.pins.wheel[0]); }},
    {"pin.wheel_right",
     [](std::string_view v, Settings& out) { return read_encoder(v, out.pins.wheel[1]); }},
    {"record", [](std::string_view v, Settings& out) { return read_text(v, out.record); }},
    {"recordings", [](std::string_view v, Settings& out) { return read_text(v, out.recordings); }},
    {"map", read_map_name},
    {"watchdog", [](std::string_view v, Settings& out) { return read_text(v, out.watchdog); }},
    {"realtime",
     [](std::string_view v, Settings& out) -> const char* {
       return read_yes_no(v, out.realtime) ? nullptr : "yes or no";
     }},
};

bool triggers(const Settings& settings) {
  return settings.trigger.pwm_chip >= 0 || settings.pins.trigger.text[0] != 0;
}

}  // namespace

const char* set_setting(Settings& settings, std::string_view key, std::string_view value) {
  for (const Key& known : kKeys) {
    if (key == known.name) return known.read(value, settings);
  }
  const std::string_view link = behind(key, kLink);
  if (!link.empty()) return set_link_setting(settings.link, link, value);
  if (key == "gnss") return set_gnss_setting(settings.gnss, "", value);
  const std::string_view gnss = behind(key, kGnss);
  if (!gnss.empty()) return set_gnss_setting(settings.gnss, gnss, value);
  if (is_usb_key(key)) {
    UsbSettings usb;  // pirvs-usb's: here for their faults alone
    return set_usb_setting(usb, key, value);
  }
  const std::string_view parameter = behind(key, kParameter);
  if (parameter.empty()) return "no such key";
  const ParamAnswer answer = set_parameter(settings.params, parameter, value);
  return answer.ok() ? nullptr : name(answer.status);
}

const char* folder_of(const Settings& settings) {
  if (settings.record.text[0] != 0) return settings.record.text;
  return settings.recordings.text[0] != 0 ? settings.recordings.text : ".";
}

int isp_of(const SettingText& camera) {
  const std::string_view number = behind(camera.text, "isp:");
  return number.empty() ? -1 : number[0] - '0';
}

void finish_settings(Settings& settings) {
  if (!triggers(settings)) return;
  ExposureParams& exposure = settings.params.exposure;
  const float period_s = static_cast<float>(to_seconds(settings.trigger.timing.period_ns));
  constexpr float kLeast_s = 1e-4f;  // as its row allows
  exposure.longest_s =
      std::clamp(period_s - exposure.readout_s, kLeast_s, std::max(kLeast_s, exposure.longest_s));
}

namespace {

bool same(const SettingText& a, const SettingText& b) { return std::strcmp(a.text, b.text) == 0; }

ConfigFault find_trigger_fault(const Settings& settings) {
  if (!triggers(settings)) return {};
  const bsp::TriggerTiming& timing = settings.trigger.timing;
  const bool by_pin = settings.pins.trigger.text[0] != 0;
  if (by_pin && settings.trigger.pwm_chip >= 0) {
    return {0, "a pin and a PWM cannot both trigger the cameras", "pin.trigger"};
  }
  if (!settings.has_trigger_rate) return {0, "a trigger needs its rate", "trigger.rate_hz"};
  if (by_pin && (timing.width_ns == 0 || timing.width_ns > timing.period_ns / 2)) {
    return {0, "a pin's pulse is at most half a period long", "trigger.width_us"};
  }
  return {};
}

}  // namespace

ConfigFault find_missing(const Settings& settings) {
  const struct {
    const SettingText& value;
    const char* key;
  } needed[] = {{settings.calibration, "calibration"},
                {settings.camera[0], "camera.left"},
                {settings.imu, "imu"}};
  for (const auto& row : needed) {
    if (row.value.text[0] == 0) return {0, "a key is missing", row.key};
  }
  if (settings.imu_is_on_i2c && settings.imu_data_ready.text[0] == 0) {
    return {0, "an IMU on I2C needs the pin of its interrupt", "imu.data_ready"};
  }
  if (settings.record.text[0] != 0 && settings.recordings.text[0] != 0) {
    return {0, "record names their folder already", "recordings"};
  }
  const LinkSettings& link = settings.link;
  if (link.serial.text[0] != 0 && same(link.serial, settings.serial)) {
    return {0, "the text of output.serial goes there", "link.serial"};
  }
  const GnssSettings& gnss = settings.gnss;
  if (gnss.serial.text[0] != 0 &&
      (same(gnss.serial, settings.serial) || same(gnss.serial, link.serial))) {
    return {0, "another line of the device's goes there", "gnss"};
  }
  if (!gnss.is_wanted() && gnss.is_set) return {0, "a receiver needs a line", "gnss"};
  if (!link.is_wanted() && link.is_set)
    return {0, "a link needs a wire", "link.udp or link.serial"};
  return find_trigger_fault(settings);
}

ConfigFault read_settings(std::string_view text, Settings& out) {
  KeyValues lines(text);
  KeyValue line;
  Status status = Status::kOk;
  while ((status = lines.next(line)) == Status::kOk) {
    const char* const what = set_setting(out, line.key, line.value);
    if (what != nullptr) return {line.line, what, line.key};
  }
  return status == Status::kBadData ? lines.fault() : ConfigFault{};
}

}  // namespace pirvs::board
