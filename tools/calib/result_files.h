// What    The files that a calibration leaves.
// In      The rig (T_BC of its cameras set, if there is an IMU) and what was found besides.
// Out     write_sensor_files   DIR/mav0/cam0/sensor.yaml ..., imu0/sensor.yaml: as recordings have
//                              them and `pirvs run --calib` and `pirvs calibration` read them
//         write_camchain       DIR/camchain.yaml, with an IMU DIR/camchain-imucam.yaml and
//                              DIR/imu.yaml: Kalibr's
//         write_device_file    calibration.cfg, as a device reads it
//         camera_json, imu_json  parts of DIR/calibration.json: values, sigmas, residuals
// Units   as Kalibr and ASL have them: px, m, rad, s; timeshift: t_imu = t_cam + shift.
// Errors  InputError: cannot be written; a calibration that the stack would refuse.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "modules/imu/imu_intrinsics.h"
#include "tools/calib/cameras.h"
#include "tools/calib/imu_camera.h"

namespace pirvs::tools {

const char* model_name(CameraModel model);  // radtan or equidistant

struct FoundImu {
  ImuNoise noise;
  ImuIntrinsics intrinsics;
};
ImuIntrinsics intrinsics_of(const ImuCameraResult& result);

// offset_s: of each camera; imu: null without one.
void write_sensor_files(const std::string& folder, const CameraRig& rig, const double* offset_s,
                        const FoundImu* imu);
void write_camchain(const std::string& folder, const CameraRig& rig, const double* offset_s,
                    const FoundImu* imu);

// The left camera's offset moves the pair.
void write_device_file(const std::string& path, const CameraRig& rig, const double* offset_s,
                       const FoundImu& imu);

void write_imu_yaml(const std::string& path, const FoundImu& imu);

nlohmann::json camera_json(const CameraResult& result);
nlohmann::json imu_json(const ImuCameraResult& result);
void write_json(const std::string& path, const nlohmann::json& json);

}  // namespace pirvs::tools
