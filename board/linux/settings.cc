#include "board/linux/settings.h"

#include <cstring>
#include <iterator>

namespace pirvs::board {
namespace {

constexpr TimeNs kMicro = 1'000, kMilli = 1'000'000;
constexpr std::string_view kParameter = "parameter.";

struct Choice {
  const char* word;
  int value;
};

// Each reads a value: nullptr, or what is wrong with it.
const char* read_text(std::string_view value, SettingText& out) {
  if (value.size() >= sizeof out.text) return "longer than 95 bytes";
  std::memcpy(out.text, value.data(), value.size());
  out.text[value.size()] = 0;
  return nullptr;
}

template <size_t N>
bool read_choice(std::string_view value, const Choice (&choices)[N], int& out) {
  for (const Choice& choice : choices) {
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
  constexpr Choice kChoices[] = {{"trigger", static_cast<int>(bsp::Pairing::kTrigger)},
                                 {"stamp", static_cast<int>(bsp::Pairing::kStamp)}};
  int choice = 0;
  if (!read_choice(value, kChoices, choice)) return "trigger or stamp";
  out.stereo.pairing = static_cast<bsp::Pairing>(choice);
  return nullptr;
}

const char* read_clock(std::string_view value, Settings& out) {
  constexpr Choice kChoices[] = {{"monotonic", static_cast<int>(bsp::StampClock::kMonotonic)},
                                 {"boottime", static_cast<int>(bsp::StampClock::kBoottime)}};
  int choice = 0;
  if (!read_choice(value, kChoices, choice)) return "monotonic or boottime";
  for (auto& camera : out.stereo.camera) camera.clock = static_cast<bsp::StampClock>(choice);
  return nullptr;
}

const char* read_stamp(std::string_view value, Settings& out) {
  constexpr Choice kChoices[] = {
      {"driver", static_cast<int>(bsp::StampMeans::kDriver)},
      {"exposure_start", static_cast<int>(bsp::StampMeans::kExposureStart)},
      {"frame_end", static_cast<int>(bsp::StampMeans::kFrameEnd)}};
  int choice = 0;
  if (!read_choice(value, kChoices, choice)) return "driver, exposure_start or frame_end";
  for (auto& camera : out.stereo.camera) camera.means = static_cast<bsp::StampMeans>(choice);
  return nullptr;
}

const char* read_output(std::string_view value, Settings& out) {
  constexpr Choice kChoices[] = {{"poses", static_cast<int>(TextOutput::kPoses)},
                                 {"frames", static_cast<int>(TextOutput::kFrames)},
                                 {"none", static_cast<int>(TextOutput::kNone)}};
  int choice = 0;
  if (!read_choice(value, kChoices, choice)) return "poses, frames or none";
  out.text = static_cast<TextOutput>(choice);
  return nullptr;
}

// 192.168.7.2:14550
const char* read_endpoint(std::string_view value, Settings& out) {
  constexpr const char* kWrong = "not an address and a port, as 192.168.7.2:14550";
  uint32_t address = 0;
  const char* at = value.data();
  const char* const end = at + value.size();
  for (int i = 0; i < 5; ++i) {
    const char* stop = at;
    while (stop < end && *stop != '.' && *stop != ':') ++stop;
    int64_t part = 0;
    if (!read_whole({at, static_cast<size_t>(stop - at)}, i == 4 ? 1 : 0, i == 4 ? 65'535 : 255,
                    part)) {
      return kWrong;
    }
    if (i == 4) {
      if (stop != end) return kWrong;
      out.poses_to = {address, static_cast<uint16_t>(part)};
      out.has_poses_to = true;
      return nullptr;
    }
    if (stop == end || *stop != (i == 3 ? ':' : '.')) return kWrong;
    address = address << 8 | static_cast<uint32_t>(part);
    at = stop + 1;
  }
  return kWrong;
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
  constexpr std::string_view kIio = "iio:";
  const bool iio =
      value.size() > kIio.size() && std::string_view(value.data(), kIio.size()) == kIio;
  return iio ? read_text(value, out.imu) : "an IMU is iio: and its number or name";
}

const char* read_exposure(std::string_view value, Settings& out) {
  for (auto& camera : out.stereo.camera) {
    if (const char* const why = read_time(value, kMicro, 100 * kMilli, camera.exposure_ns)) {
      return why;
    }
  }
  return nullptr;
}

const char* read_readout(std::string_view value, Settings& out) {
  for (auto& camera : out.stereo.camera) {
    if (const char* const why = read_time(value, kMicro, 100 * kMilli, camera.readout_ns)) {
      return why;
    }
  }
  return nullptr;
}

struct Key {
  const char* name;
  const char* (*read)(std::string_view, Settings&);
};
constexpr Key kKeys[] = {
    {"calibration",
     [](std::string_view v, Settings& out) { return read_text(v, out.calibration); }},
    {"camera.left", [](std::string_view v, Settings& out) { return read_text(v, out.camera[0]); }},
    {"camera.right", [](std::string_view v, Settings& out) { return read_text(v, out.camera[1]); }},
    {"camera.left_events",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_events[0]); }},
    {"camera.right_events",
     [](std::string_view v, Settings& out) { return read_text(v, out.camera_events[1]); }},
    {"camera.pairing", read_pairing},
    {"camera.clock", read_clock},
    {"camera.stamp", read_stamp},
    {"camera.exposure_us", read_exposure},
    {"camera.readout_us", read_readout},
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
    {"imu.delay_us",
     [](std::string_view v, Settings& out) {
       return read_time(v, kMicro, 100 * kMilli, out.iio.delay_ns);
     }},
    {"output.text", read_output},
    {"output.poses", read_endpoint},
    {"record", [](std::string_view v, Settings& out) { return read_text(v, out.record); }},
    {"realtime",
     [](std::string_view v, Settings& out) -> const char* {
       return read_yes_no(v, out.realtime) ? nullptr : "yes or no";
     }},
};

}  // namespace

const char* set_setting(Settings& settings, std::string_view key, std::string_view value) {
  for (const Key& known : kKeys) {
    if (key == known.name) return known.read(value, settings);
  }
  const bool is_parameter = key.size() > kParameter.size() &&
                            std::string_view(key.data(), kParameter.size()) == kParameter;
  if (!is_parameter) return "no such key";
  key.remove_prefix(kParameter.size());
  const ParamAnswer answer = set_parameter(settings.params, key, value);
  return answer.ok() ? nullptr : name(answer.status);
}

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
  return {};
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
