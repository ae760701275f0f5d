// `pirvs sim --out SEQ`: makes a recording with exact ground truth.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/dataset/input_error.h"
#include "tools/sim/sim.h"

namespace pirvs::tools {
namespace {

void declare_world(CLI::App& app, SimOptions& o) {
  app.add_option("--out", o.out, "folder to write, ASL/EuRoC layout")->required();
  app.add_option(
         "--camera", o.device,
         "euroc: 752x480 20 Hz radtan; ironsides: 640x480 60 Hz fisheye; tumvi: 512x512 20 Hz "
         "fisheye; t265: 848x800 30 Hz fisheye; oakd: 1280x800 30 Hz pinhole")
      ->capture_default_str();
  app.add_option("--path", o.path,
                 "'spline', 'rest', 'steady' or a ground-truth file (ASL csv, TUM) to fly along")
      ->capture_default_str();
  app.add_option("--duration", o.duration_s, "seconds; with a file: at most")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--rest", o.rest_s, "seconds at rest before a spline or steady flight")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--rate", o.rate_hz, "camera frames per second (default: the device's)")
      ->check(CLI::Range(1.0, 500.0));
  app.add_option("--seed", o.seed, "same seed, same bytes")->capture_default_str();
  app.add_option("--boxes", o.boxes, "boxes in the hall")
      ->capture_default_str()
      ->check(CLI::Range(0, 500));
  app.add_option("--movers", o.movers, "how many of them move")
      ->capture_default_str()
      ->check(CLI::Range(0, 500));
  app.add_option("--mover", o.mover, "share of the view filled by an object that sways before it")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 0.9));
  app.add_option("--mover-from", o.mover_from_s, "when it comes in, s; 0: there from the start")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--threads", o.threads, "threads that draw")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  app.add_option("--format", o.format, "png, jpg or pgm (fast, large)")
      ->capture_default_str()
      ->check(CLI::IsMember({"png", "jpg", "pgm"}));
}

void declare_steady(CLI::App& app, SimOptions& o) {
  app.add_option("--forward", o.forward_m_s, "m/s along the view, steady path")
      ->capture_default_str();
  app.add_option("--left", o.left_m_s, "m/s across the view, steady path")->capture_default_str();
  app.add_option("--turn", o.turn_deg_s, "deg/s about the vertical, steady path")
      ->capture_default_str();
  app.add_option("--ramp", o.ramp_s, "seconds from rest to that")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 1e3));
}

void declare_imu(CLI::App& app, SimOptions& o) {
  app.add_option("--gyro-noise", o.gyro_noise, "rad/s/sqrt(Hz) (default: the device's)");
  app.add_option("--gyro-walk", o.gyro_walk, "rad/s^2/sqrt(Hz)");
  app.add_option("--accel-noise", o.accel_noise, "m/s^2/sqrt(Hz)");
  app.add_option("--accel-walk", o.accel_walk, "m/s^3/sqrt(Hz)");
  app.add_flag("--imu-as-expected", o.imu_as_expected,
               "noise and biases as the estimator's parameters expect them, sensor.yaml unchanged");
  app.add_option("--gyro-bias", o.gyro_bias_rad_s, "sigma of the bias at the start, rad/s")
      ->capture_default_str();
  app.add_option("--accel-bias", o.accel_bias_m_s2, "sigma of the bias at the start, m/s^2")
      ->capture_default_str();
}

void declare_image(CLI::App& app, SimOptions& o) {
  app.add_option("--exposure", o.exposure_ms, "shutter time, ms")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--blur", o.blur, "sub-images per exposure at most; 1: no motion blur")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  app.add_option("--noise", o.image_noise, "image noise, grey values at mid grey")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--exposure-change", o.exposure_change, "relative change of brightness over time")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--dark", o.dark, "share of the light taken away")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--dark-from", o.dark_from_s, "when it gets dark, s")->capture_default_str();
  app.add_option("--dark-for", o.dark_for_s, "for how long, s; 0: to the end")
      ->capture_default_str();
}

// A recording is there as a whole or not at all: it is drawn into a folder beside its place.
void simulate_whole(const SimOptions& options, const SimProgress& progress) {
  std::error_code error;
  if (std::filesystem::exists(options.out) && !std::filesystem::is_empty(options.out, error)) {
    throw InputError("not an empty folder", options.out, "choose another --out");
  }
  SimOptions part = options;
  while (part.out.size() > 1 && part.out.back() == '/') part.out.pop_back();
  part.out += ".part";
  std::filesystem::remove_all(part.out, error);
  try {
    simulate(part, progress);
    std::filesystem::rename(part.out, options.out);
  } catch (const std::filesystem::filesystem_error&) {
    std::filesystem::remove_all(part.out, error);
    throw InputError("cannot write", options.out, "check what is there now");
  } catch (...) {
    std::filesystem::remove_all(part.out, error);
    throw;
  }
}

std::function<int()> declare(CLI::App& app) {
  const auto options = std::make_shared<SimOptions>();
  declare_world(app, *options);
  declare_steady(app, *options);
  declare_imu(app, *options);
  declare_image(app, *options);
  return [options] {
    {
      std::unique_ptr<Progress> bar;
      simulate_whole(*options, [&bar](size_t done, size_t total) {
        if (!bar) bar = std::make_unique<Progress>("simulating", total);
        bar->update(done);
      });
    }
    std::printf("simulated recording: %s\n", options->out.c_str());
    return kExitDone;
  };
}

}  // namespace

const Command kSimCommand = {"sim", "Make a simulated recording with exact ground truth", declare};

}  // namespace pirvs::tools
