// What    Reads a calibration: the sensor.yaml files of an ASL folder, Kalibr's camchain, or a
//         device's own file (modules/calibration/calibration_text.h).
// In      ASL: pinhole + radial-tangential | equidistant, T_BS 4 x 4, perhaps
//         timeshift_cam_imu.
//         Kalibr camchain-imucam.yaml: pinhole + radtan | equidistant, T_cam_imu or T_cn_cnm1,
//         timeshift_cam_imu; and imu.yaml beside it, if there is one.
// Out     A Calibration; cameras = 1 if there is only cam0.
// Frames  B = the IMU: T_BC takes camera to IMU coordinates.
// Units   pixels with (0,0) at the centre of the first pixel; metres; ns.
// Errors  InputError naming file and key: missing, wrong size, not a rotation, unknown model.
// Source  ASL data set format (Burri et al., IJRR 2016); Kalibr wiki, "YAML formats".
#pragma once

#include <string>

#include "modules/calibration/calibration.h"
#include "modules/wheels/wheel_sample.h"

namespace pirvs::tools {

// mav0 holds cam0/sensor.yaml, imu0/sensor.yaml, perhaps cam1/sensor.yaml.
Calibration read_asl_calibration(const std::string& mav0);

// noise: used for the IMU if no imu.yaml stands beside the camchain.
Calibration read_kalibr_calibration(const std::string& path, const ImuNoise& noise);

// By the name of the file: a device's *.cfg, or Kalibr's camchain and the noise as above.
Calibration read_calibration_file(const std::string& path, const ImuNoise& noise);

// InputError if find_fault() finds one; `where`: the file or folder that it was read from.
void check_sense(const Calibration& calibration, const std::string& where);

// One camera's sensor.yaml; T_BC and the offset to the clock of the IMU as the file has them.
Camera read_asl_camera(const std::string& path, TimeNs& camera_time_offset_ns);

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

// Noise densities of an ASL sensor.yaml or a Kalibr imu.yaml (they share their keys).
ImuNoise read_imu_noise(const std::string& path);

}  // namespace pirvs::tools
