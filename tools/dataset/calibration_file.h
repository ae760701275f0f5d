// What    The calibration of a recording: whoever's file it is, as the stack takes it.
// In      The sensor.yaml files of an ASL folder, a device's own file (calibration_text.h), or one
//         of the families of rig_file.h. Which cameras of it, and noise densities of elsewhere.
// Out     A Rig: the calibration of the images as they are played, and how that is. A lens that the
//         stack does not compute itself is fitted; what was done is noted in the log. Unless
//         as_mounted: a right camera that is rolled by about quarter turns against the left one
//         gets its images turned back, and cameras named in the wrong order change places.
// Frames  B = the IMU: T_BC takes camera to IMU coordinates.
// Units   pixels with (0,0) at the centre of the first pixel; metres; ns.
// Errors  InputError naming file and key: missing, wrong size, not a rotation, unknown model, a fit
//         worse than 0.1 px, a calibration that makes no sense.
// Source  ASL data set format (Burri et al., IJRR 2016); docs/formats.md.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "modules/calibration/calibration.h"
#include "modules/wheels/wheel_sample.h"
#include "tools/dataset/input_log.h"

namespace pirvs::tools {

struct RigFile;

struct RigOptions {
  std::string imu;           // a file with noise densities; empty: the calibration's own
  std::string fallback_imu;  // used if there are none, if it exists
  std::vector<int> cameras;  // left and right, as numbered in the file; empty: 0 and 1
  bool mono = false;
  bool as_mounted = false;  // of a device, which turns no images
  // Width and height of the images, asked if the file has lenses for several sizes; empty: not
  // known. A pair of zeros: no image is to be had.
  std::function<std::pair<int, int>()> image_size;
};

struct Rig {
  Calibration calibration;
  int camera[2] = {0, 1};       // as numbered in the file or folder
  int turns[2] = {0, 0};        // quarter turns, clockwise, of the images before they are played
  TimeNs shift_ns[2] = {0, 0};  // t_imu = stamp + shift, of each
  bool has_rate = true;         // else calibration.imu.rate_hz is a guess
};

// By what the file is.
Rig read_rig(const std::string& path, const RigOptions& options, InputLog& log);
// `path`: what it was read from.
Rig make_rig(const RigFile& file, const std::string& path, const RigOptions& options,
             InputLog& log);
// mav0 holds cam0/sensor.yaml, imu0/sensor.yaml, perhaps cam1/sensor.yaml.
Rig read_asl_rig(const std::string& mav0, const RigOptions& options, InputLog& log);

// InputError if find_fault() finds one; `where`: the file or folder that it was read from.
void check_sense(const Calibration& calibration, const std::string& where);

// The camera of an image that was turned clockwise by quarters.
Camera turned(const Camera& camera, int quarters);

// gnss0/sensor.yaml: T_BS, and what a simulator knows besides.
struct GnssSensor {
  GnssAntenna antenna;
  TimeNs latency_ns = 0;  // from a fix's time to its arrival
  // The world of the recording's ground truth: its origin, and the angle from east to its x axis,
  // counter-clockwise.
  bool has_truth = false;
  double truth_latitude_deg = 0, truth_longitude_deg = 0, truth_height_m = 0;
  double truth_heading_deg = 0;
};
GnssSensor read_gnss_sensor(const std::string& path);

// wheel0/sensor.yaml of an ASL folder: kind (left_right, twist, ticks, steering); T_BS: the vehicle
// in the body; track, wheelbase, radius [m]; ticks_per_turn; time_offset [s].
struct WheelSensor {
  WheelCalibration calibration;
  WheelKind kind = WheelKind::kLeftRight;
};
WheelSensor read_wheel_sensor(const std::string& path);

}  // namespace pirvs::tools
