// `pirvs calib device`: one recording in; calibration files, a page, pass or fail out.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "modules/calibration/calibration_text.h"
#include "tools/calib/board_images.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"
#include "tools/calib/device_calibration.h"
#include "tools/calib/result_files.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/report/page.h"

namespace pirvs::tools {
namespace {

struct Options {
  CornerOptions corners;
  std::string imu, noise, out, serial;
};

DeviceRecording read(const Options& o) {
  CornerInput input = read_corner_input(o.corners);
  DeviceRecording out;
  out.target = input.target;
  out.shots = std::move(input.shots);
  out.cameras = input.cameras;
  out.how = input.how;
  out.tags_twice = input.tags_twice;
  const std::string own = o.corners.sequence.empty() ? "" : mav0_of(o.corners.sequence) + "/imu0";
  const std::string path = o.imu.empty() ? own + "/data.csv" : o.imu;
  InputLog log;
  out.imu = read_imu_samples(path, log);
  print_log(path, log);
  const bool has_own = !own.empty() && std::filesystem::exists(own + "/sensor.yaml");
  if (!o.noise.empty() || has_own) {
    out.motion.noise = read_noise(o.noise.empty() ? own + "/sensor.yaml" : o.noise);
  }
  return out;
}

std::string row(const DeviceCheck& check) {
  char text[160];
  std::snprintf(text, sizeof text, "%-44s %9.4f %-8s limit %g%s", check.what.c_str(), check.value,
                check.unit.c_str(), check.limit, check.passed() ? "" : "  FAILED");
  return text;
}

// What the stack would refuse is not handed out.
void write_device_file(const std::string& path, const DeviceResult& r, const FoundImu& imu) {
  Calibration calibration;
  calibration.cameras = r.imu.rig.cameras;
  for (int c = 0; c < calibration.cameras; ++c) calibration.camera[c] = r.imu.rig.camera[c];
  calibration.imu = imu.noise;
  calibration.imu_intrinsics = imu.intrinsics;
  calibration.camera_time_offset_ns = from_seconds(r.imu.camera[0].offset_s);
  check_sense(calibration, "the calibration that was found");
  ::pirvs::Text<kCalibrationTextMax> text;
  write_calibration(calibration, text);
  std::ofstream file(path);
  file << "# Written by `pirvs calib device`.\n" << text.c_str();
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

std::string page(const Options& o, const DeviceResult& r) {
  std::string out = "<header><div><h1>" + std::string(r.passed() ? "Passed" : "Failed") +
                    "</h1><div class=sub>" + html_escape(o.serial + " " + o.corners.sequence) +
                    "</div></div></header>\n<div class=card><table>\n"
                    "<tr><th>what</th><th>found</th><th>limit</th><th></th></tr>\n";
  for (const DeviceCheck& check : r.checks) {
    char numbers[96];
    std::snprintf(numbers, sizeof numbers, "<td>%.4f %s</td><td>%g</td><td>%s</td>", check.value,
                  check.unit.c_str(), check.limit, check.passed() ? "" : "failed");
    out += "<tr><td>" + html_escape(check.what) + "</td>" + numbers + "</tr>\n";
  }
  out += "</table></div>\n";
  for (const std::string& warning : r.warnings) {
    out += "<div class=card>" + html_escape(warning) + "</div>\n";
  }
  for (const std::string& what : r.imu.unexcited) {
    out += "<div class=card>not told by the motion: " + html_escape(what) + "</div>\n";
  }
  for (int c = 0; c < r.cameras.rig.cameras; ++c) {
    out += "<div class=card><h2>Tags seen by cam" + std::to_string(c) + "</h2><pre>" +
           html_escape(picture(r.cameras.coverage, c)) + "</pre></div>\n";
  }
  return html_page("Calibration " + html_escape(o.serial), out);
}

void write(const Options& o, const DeviceResult& r, const ImuNoise& noise) {
  const double offset_s[2] = {r.imu.camera[0].offset_s, r.imu.camera[1].offset_s};
  const FoundImu found{noise, intrinsics_of(r.imu)};
  nlohmann::json json = {{"serial", o.serial},
                         {"passed", r.passed()},
                         {"warnings", r.warnings},
                         {"cameras", camera_json(r.cameras)},
                         {"imu_camera", imu_json(r.imu)}};
  for (const DeviceCheck& check : r.checks) {
    json["checks"].push_back({{"what", check.what},
                              {"unit", check.unit},
                              {"value", check.value},
                              {"limit", check.limit},
                              {"passed", check.passed()}});
  }
  write_json(o.out + "/calibration.json", json);
  std::ofstream file(o.out + "/calibration.html");
  file << page(o, r);
  file.close();
  if (!file) throw InputError("cannot write", o.out, "check space and permissions");
  if (!r.passed()) return;  // no device is to get what has failed
  write_sensor_files(o.out, r.imu.rig, offset_s, &found);
  write_camchain(o.out, r.imu.rig, offset_s, &found);
  write_device_file(o.out + "/calibration.cfg", r, found);
}

int run(const Options& o) {
  DeviceRecording recording = read(o);
  const ImuNoise noise = recording.motion.noise;
  const DeviceResult result = calibrate_device(std::move(recording), {});
  for (const std::string& warning : result.warnings) {
    std::fprintf(stderr, "pirvs: calib: %s\n", warning.c_str());
  }
  for (const DeviceCheck& check : result.checks) std::printf("%s\n", row(check).c_str());
  write(o, result, noise);
  std::printf("%s%s%s, written: %s\n", o.serial.c_str(), o.serial.empty() ? "" : " ",
              result.passed() ? "PASSED" : "FAILED", o.out.c_str());
  return result.passed() ? kExitDone : kExitFailed;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  o->corners.rate_hz = 12;
  declare_corners(app, o->corners);
  app.add_option("--imu", o->imu, "samples, else the recording's");
  app.add_option("--noise", o->noise, "densities, else the recording's imu0/sensor.yaml");
  app.add_option("--serial", o->serial, "the device's number, for page and json");
  app.add_option("--out", o->out,
                 "folder for calibration.html and .json; if it passes, sensor.yaml files, Kalibr's "
                 "yaml and calibration.cfg")
      ->required();
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibDeviceCommand = {
    "device", "A device's whole calibration from one recording: pass or fail", declare};

}  // namespace pirvs::tools
