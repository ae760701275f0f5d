#include "board/linux/input.h"

#include <cstring>

#include "board/linux/say.h"
#include "bsp/linux/text_file.h"
#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"

namespace pirvs::board {
namespace {

char config_text[kSettingsTextMax];
char calibration_text[kCalibrationTextMax + kSettingsTextMax];

// The whole file as text; says why not.
bool read_file(const char* path, char* out, size_t max, std::string_view& text) {
  const char* const why = bsp::read_text_file(path, out, max, text);
  if (why != nullptr) say(path, why);
  return why == nullptr;
}

bool say_fault(const char* path, const ConfigFault& fault) {
  Text<512> line;
  line.put("pirvsd: ");
  put_fault(line, path, fault);
  say(line);
  return false;
}

bool take_setting(Settings& out, std::string_view key, std::string_view value) {
  const char* const why = set_setting(out, key, value);
  return why == nullptr || say_fault("command line", {0, why, key});
}

bool take_cameras(Settings& out, std::string_view value) {
  const size_t comma = value.find(',');
  const size_t end = comma == std::string_view::npos ? value.size() : comma;
  if (!take_setting(out, "camera.left", {value.data(), end})) return false;
  if (end == value.size()) return true;
  return take_setting(out, "camera.right", {value.data() + end + 1, value.size() - end - 1});
}

bool take_assignment(Settings& out, std::string_view text) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return say_fault("command line", {0, "--set wants KEY=VALUE", text});
  }
  return take_setting(out, {text.data(), equals},
                      {text.data() + equals + 1, text.size() - equals - 1});
}

bool take_option(Settings& out, const char* option, const char* value) {
  if (std::strcmp(option, "--camera") == 0) return take_cameras(out, value);
  if (std::strcmp(option, "--imu") == 0) return take_setting(out, "imu", value);
  if (std::strcmp(option, "--calibration") == 0) return take_setting(out, "calibration", value);
  if (std::strcmp(option, "--set") == 0) return take_assignment(out, value);
  return say_fault("command line", {0, "no such option, see --help", option});
}

// A path of the file is meant from where the file lies.
void from_folder_of(const char* file, SettingText& path) {
  const char* const slash = std::strrchr(file, '/');
  if (path.text[0] == 0 || path.text[0] == '/' || slash == nullptr) return;
  Text<sizeof(path.text)> joined;
  for (const char* c = file; c <= slash; ++c) joined.put(*c);
  joined.put(path.text);
  if (!joined.full()) std::memcpy(path.text, joined.c_str(), joined.size() + 1);
}

}  // namespace

bool read_config(const char* path, Settings& out) {
  std::string_view text;
  if (!read_file(path, config_text, sizeof config_text, text)) return false;
  if (const ConfigFault fault = read_settings(text, out)) return say_fault(path, fault);
  from_folder_of(path, out.calibration);
  return true;
}

bool read_command_line(int argc, char** argv, bool has_isps, Settings& out) {
  int at = 1;
  if (at < argc && argv[at][0] != '-' && !read_config(argv[at++], out)) return false;
  for (; at < argc; at += 2) {
    if (at + 1 == argc) {
      return say_fault("command line", {0, "a value is missing, see --help", argv[at]});
    }
    if (!take_option(out, argv[at], argv[at + 1])) return false;
  }
  if (!has_isps && isp_of(out.camera[0]) >= 0) {
    return say_fault("settings", {0, "this board has no ISPs, name a video node", "camera.left"});
  }
  finish_settings(out);
  const ConfigFault fault = find_missing(out);
  return !fault || say_fault("settings", fault);
}

bool read_device_calibration(const Settings& settings, Calibration& calibration) {
  const char* const path = settings.calibration.text;
  std::string_view text;
  if (!read_file(path, calibration_text, sizeof calibration_text, text)) return false;
  if (const ConfigFault fault = read_calibration(text, calibration)) return say_fault(path, fault);
  if (settings.camera[1].text[0] == 0 && calibration.cameras == 2) {
    say(settings.camera[0].text, "no camera.right: tracking with the left one alone");
    calibration.cameras = 1;
  }
  put_antenna(settings.gnss, calibration.gnss);
  if (const CalibrationFault fault = find_fault(calibration)) {
    Text<512> line;
    line.put("pirvsd: ").put(path).put(", ").put(fault.where).put(": ").put(fault.what);
    line.put(": ").put(fault.what_to_do);
    say(line);
    return false;
  }
  return true;
}

}  // namespace pirvs::board
