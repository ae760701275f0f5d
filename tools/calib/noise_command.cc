// `pirvs calib noise`: noise densities of an IMU from hours at rest.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include "tools/calib/allan.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"
#include "tools/calib/result_files.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/report/figure.h"
#include "tools/report/page.h"

namespace pirvs::tools {
namespace {

constexpr double kShort_s = 600;

struct Options {
  std::string in, out;
};

struct Axis {
  std::vector<AllanPoint> points;
  FittedNoise noise;
};

double median_rate_hz(const std::vector<ImuSample>& imu) {
  std::vector<TimeNs> steps;
  for (size_t i = 1; i < imu.size(); ++i) steps.push_back(imu[i].t - imu[i - 1].t);
  const auto middle = steps.begin() + long(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return 1 / to_seconds(*middle);
}

std::vector<ImuSample> read_rest(const Options& o) {
  const bool folder = std::filesystem::is_directory(o.in);
  InputLog log;
  const std::string path = folder ? o.in + "/mav0/imu0/data.csv" : o.in;
  std::vector<ImuSample> imu = read_imu_samples(path, log);
  print_log(path, log);
  if (imu.size() < 2 || to_seconds(imu.back().t - imu.front().t) < kShort_s) {
    throw InputError("too short for an Allan variance", o.in,
                     "leave the IMU at rest for 3 hours, 10 minutes at the very least");
  }
  return imu;
}

Axis analyse(const std::vector<ImuSample>& imu, int k, double rate_hz, const std::string& where) {
  std::vector<double> values;
  for (const ImuSample& s : imu) values.push_back(k < 3 ? s.w_B[k] : s.f_B[k - 3]);
  Axis out;
  out.points = allan_deviation(values, rate_hz);
  out.noise = fit_noise(out.points);
  constexpr double kMoved[2] = {0.01, 0.1};  // rad/s, m/s^2, over seconds
  for (const AllanPoint& point : out.points) {
    if (point.tau_s < 1 || point.deviation < kMoved[k / 3]) continue;
    throw InputError("the IMU was not at rest", where,
                     "leave it alone, on a heavy table, overnight");
  }
  return out;
}

// White noise and walks of the three axes as one: root mean square.
FittedNoise joint(const Axis* axes) {
  FittedNoise out;
  for (int i = 0; i < 3; ++i) {
    out.density += axes[i].noise.density * axes[i].noise.density / 3;
    out.walk += axes[i].noise.walk * axes[i].noise.walk / 3;
  }
  out.density = std::sqrt(out.density);
  out.walk = std::sqrt(out.walk);
  return out;
}

std::string plot(const char* title, const char* unit, const Axis* axes, const FittedNoise& fit) {
  const char* const names[3] = {"x", "y", "z"};
  Figure figure;
  figure.title = title;
  figure.x_label = "averaging time, log10 of s";
  figure.y_label = std::string("Allan deviation, log10 of ") + unit;
  figure.height = 420;
  figure.shared_time = false;
  Series model{"white noise and walk", "truth", {}, {}, false};
  for (const AllanPoint& point : axes[0].points) {
    model.x.push_back(std::log10(point.tau_s));
    model.y.push_back(std::log10(modelled_deviation(fit, point.tau_s)));
  }
  figure.series.push_back(model);
  for (int i = 0; i < 3; ++i) {
    Series series{names[i], names[i], {}, {}, false};
    for (const AllanPoint& point : axes[i].points) {
      series.x.push_back(std::log10(point.tau_s));
      series.y.push_back(std::log10(point.deviation));
    }
    figure.series.push_back(series);
  }
  return "<div class=card>" + figure.svg() + "</div>\n";
}

int run(const Options& o) {
  const std::vector<ImuSample> imu = read_rest(o);
  ImuNoise noise;
  noise.rate_hz = median_rate_hz(imu);
  Axis axes[6];
  for (int k = 0; k < 6; ++k) axes[k] = analyse(imu, k, noise.rate_hz, o.in);
  const FittedNoise gyro = joint(axes), accel = joint(axes + 3);
  noise.gyro_noise = gyro.density, noise.gyro_walk = gyro.walk;
  noise.accel_noise = accel.density, noise.accel_walk = accel.walk;
  std::printf("%.0f s at %.1f Hz\n", to_seconds(imu.back().t - imu.front().t), noise.rate_hz);
  std::printf("gyro           %.4g rad/s/sqrt(Hz), walk %.4g rad/s^2/sqrt(Hz)\n", gyro.density,
              gyro.walk);
  std::printf("accelerometer  %.4g m/s^2/sqrt(Hz), walk %.4g m/s^3/sqrt(Hz)\n", accel.density,
              accel.walk);
  if (o.out.empty()) return kExitDone;
  write_imu_yaml(o.out + "/imu.yaml", {noise, {}});
  std::ofstream page(o.out + "/noise.html");
  page << html_page("IMU noise", "<header><div><h1>IMU noise</h1><div class=sub>" +
                                     html_escape(o.in) + "</div></div></header>" +
                                     plot("Gyro", "rad/s", axes, gyro) +
                                     plot("Accelerometer", "m/s²", axes + 3, accel));
  page.close();
  if (!page) throw InputError("cannot write", o.out, "check space and permissions");
  std::printf("written: %s\n", o.out.c_str());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("REC", o->in, "samples at rest: an ASL folder, or its imu0/data.csv")->required();
  app.add_option("--out", o->out, "folder for imu.yaml and noise.html");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibNoiseCommand = {"noise", "Noise densities of an IMU from hours at rest",
                                    declare};

}  // namespace pirvs::tools
