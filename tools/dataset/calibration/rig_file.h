// What    What other people's calibration files say of a rig, family by family.
// In      Kalibr: camchain, camchain-imucam, imu.yaml. OpenVINS: estimator_config.yaml and what it
//         names. Basalt: JSON. ORB-SLAM3: yaml, File.version 1.0. VINS-Fusion, VINS-Mono: yaml and
//         the cameras that it names. OKVIS, OKVIS2: yaml. DepthAI: JSON of a device's EEPROM.
//         RealSense: what rs-enumerate-devices -c prints. ASL: one sensor.yaml (read_asl_sensor).
//         The keys tell which it is (docs/formats.md).
// Out     All cameras of the file in its order, with the lens as the file has it.
// Frames  B = the IMU; T_BC takes camera to IMU coordinates, whichever way the file has it.
// Units   metres, pixels; shift_ns: t_imu = t_camera + shift, Kalibr's timeshift_cam_imu.
// Errors  InputError with file and key, and what to do.
// Source  docs/formats.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "modules/imu/imu_intrinsics.h"
#include "modules/imu/imu_noise.h"
#include "tools/dataset/calibration/document.h"
#include "tools/dataset/calibration/lens.h"

namespace pirvs::tools {

struct RigCamera {
  std::string name;   // "cam0"
  std::string topic;  // that it had in its log, if the file says
  Lens lens;
  SE3 T_BC;
  TimeNs shift_ns = 0;
  std::vector<Lens> sizes;  // of all sizes that the file has, if it has several
};

struct RigNoise {
  ImuNoise noise;
  bool has_rate = false;  // else noise.rate_hz is a guess
  std::string from;       // file, and where in it
  ImuIntrinsics intrinsics;
};

struct RigFile {
  std::vector<RigCamera> cameras;
  std::optional<RigNoise> imu;
  std::optional<RigNoise> usual;  // of such devices, where nothing else is given
  bool resizes = false;           // the device scales and crops what its lenses see
  std::vector<std::string> notes;
};

RigFile read_rig_file(const std::string& path);
// A camera's lens at the size of its images; 0 x 0: they are not known, there must be one size.
Lens lens_at(const RigFile& rig, const RigCamera& camera, int width, int height,
             const std::string& path);
// The cameras' topics, in the file's order; none if it is a device's own file.
std::vector<std::string> rig_topics(const std::string& path);
// The IMU of any of them; of an ASL sensor.yaml; of Kalibr's imu.yaml, flat or below imu0. nullopt:
// the file has no densities.
std::optional<RigNoise> find_noise(const std::string& path);

// Of an ASL sensor.yaml; T_BC = its T_BS.
RigCamera read_asl_sensor(const Document& file);
std::optional<RigNoise> noise_of(const Document& file);

// The families, each alone.
RigFile read_kalibr(const Document& file);
RigFile read_openvins(const Document& file);
RigFile read_basalt(const Document& file);
RigFile read_orbslam(const Document& file);
RigFile read_vins(const Document& file);
RigFile read_okvis(const Document& file);
RigFile read_depthai(const Document& file);
bool is_realsense(const std::string& path);
RigFile read_realsense(const std::string& path);

// Parts that several share.
void set_size(const Document& file, double width, double height, const char* key, Lens& lens);
void set_intrinsics(const Document& file, const std::vector<double>& k, const char* key,
                    Lens& lens);
// By the names that Kalibr, ROS, ASL and OKVIS give it.
void set_distortion(const Document& file, const std::string& model, const char* model_key,
                    const std::vector<double>& d, const char* key, Lens& lens);
TimeNs shift_ns(const Document& file, const YAML::Node& node, const char* key);
// What the IMUs of small cameras have.
RigNoise small_imu(const char* whose);

}  // namespace pirvs::tools
