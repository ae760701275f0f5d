// `pirvs calib device`: one recording in; calibration files, a page, pass or fail out.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/math/so3.h"
#include "tools/calib/board_images.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"
#include "tools/calib/device_calibration.h"
#include "tools/calib/result_files.h"
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
  out.left_out_s = input.left_out_s;
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

// Tags in each cell of the image: the darker, the more.
std::string coverage_svg(const Coverage& coverage, int camera) {
  constexpr int kCell_px = 24, kMany = 30;
  char text[200];
  std::snprintf(text, sizeof text, "<svg viewBox=\"0 0 %d %d\" style=\"max-width:%dpx\">\n",
                kCell_px * Coverage::kColumns, kCell_px * Coverage::kRows,
                kCell_px * Coverage::kColumns);
  std::string out = text;
  for (int y = 0; y < Coverage::kRows; ++y) {
    for (int x = 0; x < Coverage::kColumns; ++x) {
      const int count = coverage.cells[camera][y][x];
      const double opacity = 0.15 + 0.85 * std::min(1.0, double(count) / kMany);
      std::snprintf(text, sizeof text,
                    "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"%s\" "
                    "fill-opacity=\"%.2f\"><title>%d</title></rect>\n",
                    kCell_px * x + 1, kCell_px * y + 1, kCell_px - 2, kCell_px - 2,
                    count > 0 ? "var(--accent)" : "var(--grid)", count > 0 ? opacity : 1.0, count);
      out += text;
    }
  }
  return out + "</svg>\n";
}

std::string found_table(const DeviceResult& r) {
  std::string out = "<table>\n<tr><th>found</th>";
  for (int c = 0; c < r.imu.rig.cameras; ++c) out += "<th>cam" + std::to_string(c) + "</th>";
  out += "</tr>\n";
  const auto row = [&](const std::string& what, const auto& value, const auto& sigma, double scale,
                       const char* unit) {
    out += "<tr><td>" + what + "</td>";
    for (int c = 0; c < r.imu.rig.cameras; ++c) {
      char text[96];
      std::snprintf(text, sizeof text, "<td>%.4f &plusmn; %.4f %s</td>", scale * value(c),
                    scale * sigma(c), unit);
      out += text;
    }
    out += "</tr>\n";
  };
  for (int i = 0; i < kLensSize; ++i) {
    row(
        kLensNames[i], [&](int c) { return lens_of(r.imu.rig.camera[c])[i]; },
        [&](int c) { return r.imu.camera[c].lens_sigma[i]; }, 1, i < 4 ? "px" : "");
  }
  const char* const axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    row(
        std::string("rotation about B's ") + axes[i],
        [&](int c) { return so3_log(r.imu.camera[c].T_BC.R)[i]; },
        [&](int c) { return r.imu.camera[c].sigma[i]; }, 180 / M_PI, "degrees");
  }
  for (int i = 0; i < 3; ++i) {
    row(
        std::string("place along B's ") + axes[i], [&](int c) { return r.imu.camera[c].T_BC.p[i]; },
        [&](int c) { return r.imu.camera[c].sigma[3 + i]; }, 1e3, "mm");
  }
  row(
      "time offset", [&](int c) { return r.imu.camera[c].offset_s; },
      [&](int c) { return r.imu.camera[c].sigma[6]; }, 1e3, "ms");
  return out + "</table>\n";
}

std::string page(const Options& o, const DeviceResult& r) {
  const bool passed = r.passed();
  std::string out = "<header><div><h1>" + std::string(passed ? "Passed" : "Failed") + " " +
                    html_escape(o.serial) + "</h1><div class=sub>" +
                    html_escape(o.corners.sequence) +
                    "</div></div></header>\n<div class=card><table>\n"
                    "<tr><th>what</th><th>measured</th><th>limit</th><th></th></tr>\n";
  for (const DeviceCheck& check : r.checks) {
    char numbers[160];
    std::snprintf(numbers, sizeof numbers,
                  "<td>%.4f %s</td><td>%g</td><td><span class=\"pill %s\">%s</span></td>",
                  check.value, check.unit.c_str(), check.limit, check.passed() ? "good" : "bad",
                  check.passed() ? "kept" : "FAILED");
    out += "<tr><td>" + html_escape(check.what) + "</td>" + numbers + "</tr>\n";
  }
  out += "</table></div>\n";
  for (const std::string& warning : r.warnings) {
    out +=
        "<div class=card><span class=\"pill warn\">odd</span> " + html_escape(warning) + "</div>\n";
  }
  for (const std::string& what : r.imu.unexcited) {
    out += "<div class=card><span class=\"pill bad\">not told by the motion</span> " +
           html_escape(what) + "</div>\n";
  }
  out += "<div class=two>\n";
  for (int c = 0; c < r.cameras.rig.cameras; ++c) {
    out += "<div class=card><h2>Tags seen by cam" + std::to_string(c) + "</h2>" +
           coverage_svg(r.cameras.coverage, c) + "</div>\n";
  }
  out += "</div>\n";
  out += "<div class=card><h2>What was found, one sigma</h2>" + found_table(r) + "</div>\n";
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
  write_device_file(o.out + "/calibration.cfg", r.imu.rig, offset_s, found);
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
  o->corners.duration_s_max = kRecording_s_max;
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
