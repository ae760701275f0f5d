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
         "fisheye; t265: 848x800 30 Hz fisheye; oakd: 1280x800 30 Hz pinhole; or a calibration: "
         "that device, drawn by the formula of its own lenses, with the errors of its IMU")
      ->capture_default_str();
  app.add_option("--path", o.path,
                 "trajectory: 'spline' (random flight), 'rest', 'steady' (constant velocity), "
                 "'hover', 'loop' (the same places again), 'handheld' (steps and shakes), "
                 "'vehicle' (on a floor, stops); a vehicle with the camera ahead of its axle: "
                 "'straight', 'spot' (turns), 'ramps', 'circuit' (300 m); or a ground-truth file "
                 "(ASL csv, TUM)")
      ->capture_default_str();
  app.add_option("--duration", o.duration_s,
                 "length of the recording, s; with a ground-truth file: at most")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--rest", o.rest_s, "standstill before the motion, s")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--rate", o.rate_hz, "camera frames per second (default: the device's)")
      ->check(CLI::Range(1.0, 500.0));
  app.add_option("--seed", o.seed, "seed of all random numbers: the same seed gives the same files")
      ->capture_default_str();
  app.add_option("--boxes", o.boxes, "number of boxes in the hall")
      ->capture_default_str()
      ->check(CLI::Range(0, 500));
  app.add_option("--movers", o.movers, "number of boxes that move")
      ->capture_default_str()
      ->check(CLI::Range(0, 500));
  app.add_option("--room", o.room,
                 "number of a hall that is the same for every flight, whatever its --seed; 0: the "
                 "hall is the flight's own")
      ->capture_default_str();
  app.add_option("--gone", o.gone, "of a room: share of its boxes that were taken away")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag("--relit", o.relit, "of a room: its lamps hang elsewhere");
  app.add_option(
         "--surfaces", o.surfaces,
         "what covers hall and boxes: mixed, chequered (repeats itself) or plain (hardly more "
         "than noise)")
      ->check(CLI::IsMember({"mixed", "chequered", "plain"}));
  app.add_option("--mover", o.mover,
                 "share of the view covered by an object that moves in front of the camera")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 0.9));
  app.add_option("--mover-from", o.mover_from_s,
                 "time at which that object appears, s; 0: from the start")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--threads", o.threads, "rendering threads")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  app.add_option("--format", o.format, "png, jpg or pgm (fast, large)")
      ->capture_default_str()
      ->check(CLI::IsMember({"png", "jpg", "pgm"}));
}

void declare_steady(CLI::App& app, SimOptions& o) {
  app.add_option("--forward", o.forward_m_s, "forward velocity of a steady path, m/s")
      ->capture_default_str();
  app.add_option("--left", o.left_m_s, "velocity to the left of a steady path, m/s")
      ->capture_default_str();
  app.add_option("--turn", o.turn_deg_s, "yaw rate of a steady path, deg/s")->capture_default_str();
  app.add_option("--ramp", o.ramp_s, "acceleration phase of a steady path, from standstill, s")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 1e3));
}

void declare_imu(CLI::App& app, SimOptions& o) {
  app.add_option("--gyro-noise", o.gyro_noise,
                 "white noise of the gyro, rad/s/sqrt(Hz) (default: the device's)");
  app.add_option("--gyro-walk", o.gyro_walk, "random walk of the gyro bias, rad/s^2/sqrt(Hz)");
  app.add_option("--accel-noise", o.accel_noise,
                 "white noise of the accelerometer, m/s^2/sqrt(Hz)");
  app.add_option("--accel-walk", o.accel_walk,
                 "random walk of the accelerometer bias, m/s^3/sqrt(Hz)");
  app.add_flag(
      "--imu-as-expected", o.imu_as_expected,
      "simulate the noise and biases that the estimator's parameters assume; sensor.yaml keeps the "
      "device's");
  app.add_option("--gyro-bias", o.gyro_bias_rad_s,
                 "standard deviation of the initial gyro bias, rad/s")
      ->capture_default_str();
  app.add_option("--accel-bias", o.accel_bias_m_s2,
                 "standard deviation of the initial accelerometer bias, m/s^2")
      ->capture_default_str();
}

void declare_gnss(CLI::App& app, SimOptions& options) {
  GnssOptions& o = options.gnss;
  app.add_option("--gnss", o.kind,
                 "add a GNSS receiver: rtk (1 cm, 5 Hz), float (0.3 m, 5 Hz) or spp (1.5 m, 1 Hz)")
      ->check(CLI::IsMember({"rtk", "float", "spp"}));
  app.add_option("--gnss-rate", o.rate_hz, "fixes per second")->check(CLI::Range(0.01, 100.0));
  app.add_option("--gnss-noise", o.sigma_m, "horizontal standard deviation of a fix, per axis, m")
      ->check(CLI::PositiveNumber);
  app.add_flag("!--gnss-no-velocity", o.velocity, "the receiver measures no velocity");
  app.add_option("--gnss-claims", o.claimed,
                 "the standard deviation that it tells over the true one")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--gnss-antenna", o.antenna, "X Y Z, lever arm of the antenna in the body, m")
      ->expected(3);
  app.add_option("--gnss-latency", o.latency_s, "time from a fix to its arrival, s")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--gnss-outage-from", o.outage_from_s, "start of an outage, s");
  app.add_option("--gnss-outage-for", o.outage_for_s, "length of the outage, s");
  app.add_option("--gnss-multipath", o.multipath_m, "error by multipath, m");
  app.add_option("--gnss-multipath-from", o.multipath_from_s, "start of the multipath, s");
  app.add_option("--gnss-multipath-for", o.multipath_for_s, "length of the multipath, s");
  app.add_option(
         "--gnss-multipath-sector", o.multipath_sector,
         "FROM TO, deg from east counter-clockwise: likewise wherever the antenna is in that "
         "sector, seen from the middle of the path")
      ->expected(2);
  app.add_option("--gnss-of", options.gnss_of,
                 "SEQ, write no recording, only the fixes along the ground truth of that one: "
                 "pirvs run SEQ --gnss OUT/data.csv");
}

void declare_wheels(CLI::App& app, WheelOptions& o) {
  app.add_option("--wheels", o.kind,
                 "add wheels that tell left_right (speeds), twist (speed, turn rate), ticks "
                 "(counters) or steering (speed, angle)")
      ->check(CLI::IsMember({"left_right", "twist", "ticks", "steering"}));
  app.add_option("--wheels-rate", o.rate_hz, "samples per second")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--wheels-noise", o.sigma_m_s, "standard deviation of a speed, m/s")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--wheels-scale", o.scale, "what wheels tell over the truth: 1.02, worn tyres")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--wheels-ticks", o.ticks_per_turn, "counts per turn of a wheel of 0.1 m radius")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  app.add_option("--wheels-spin", o.spin_m_s, "by how much the left wheel spins too fast, m/s");
  app.add_option("--wheels-spin-from", o.spin_from_s, "start of the spin, s");
  app.add_option("--wheels-spin-for", o.spin_for_s, "length of the spin, s");
}

void declare_image(CLI::App& app, SimOptions& o) {
  app.add_option("--exposure", o.exposure_ms, "exposure time, ms")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--blur", o.blur,
                 "images averaged per exposure at most, for motion blur; 1: no blur")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  app.add_option("--noise", o.image_noise,
                 "standard deviation of the image noise at mid grey, grey values")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--exposure-change", o.exposure_change, "relative change of brightness over time")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--dark", o.dark, "share of the light that is missing in the dark interval")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--dark-from", o.dark_from_s, "start of the dark interval, s")
      ->capture_default_str();
  app.add_option("--dark-for", o.dark_for_s, "length of the dark interval, s; 0: to the end")
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
  declare_gnss(app, *options);
  declare_wheels(app, options->wheels);
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
