#include "tools/calib/result_files.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "modules/calibration/calibration_text.h"
#include "modules/recorder/sensor_yaml.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/text_file.h"

namespace pirvs::tools {
namespace {

using Json = nlohmann::json;

void print_rows(TextFile& file, const char* key, const SE3& T) {
  file.print("  %s:\n", key);
  for (int i = 0; i < 3; ++i) {
    file.print("  - [%.15g, %.15g, %.15g, %.15g]\n", T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p[i]);
  }
  file.print("  - [0.0, 0.0, 0.0, 1.0]\n");
}

void print_lens(TextFile& file, const Camera& camera) {
  const char* const indent = "  ";
  file.print("%scamera_model: pinhole\n%sintrinsics: [%.12g, %.12g, %.12g, %.12g]\n", indent,
             indent, camera.fx, camera.fy, camera.cx, camera.cy);
  file.print("%sdistortion_model: %s\n", indent, model_name(camera.model));
  file.print("%sdistortion_coeffs: [%.12g, %.12g, %.12g, %.12g]\n", indent, camera.d[0],
             camera.d[1], camera.d[2], camera.d[3]);
  file.print("%sresolution: [%d, %d]\n", indent, camera.width, camera.height);
}

Json array(const double* values, int count) {
  Json out = Json::array();
  for (int i = 0; i < count; ++i) out.push_back(values[i]);
  return out;
}

Json rows(const Mat3& M) {
  Json out = Json::array();
  for (int i = 0; i < 3; ++i) out.push_back({M(i, 0), M(i, 1), M(i, 2)});
  return out;
}

Json transform(const SE3& T) {
  Json out = Json::array();
  for (int i = 0; i < 3; ++i) out.push_back({T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p[i]});
  return out;
}

Json lens_json(const Camera& camera, const double* sigma) {
  const LensVector lens = lens_of(camera);
  Json out;
  out["model"] = model_name(camera.model);
  for (int i = 0; i < kLensSize; ++i) {
    out[kLensNames[i]] = {{"value", lens[i]}, {"sigma", sigma[i]}};
  }
  return out;
}

}  // namespace

const char* model_name(CameraModel model) {
  return model == CameraModel::kPinholeRadtan ? "radtan" : "equidistant";
}

void write_sensor_files(const std::string& folder, const CameraRig& rig, const double* offset_s,
                        const FoundImu* imu) {
  for (int c = 0; c < rig.cameras; ++c) {
    Text<4096> text;
    put_camera_yaml(text, rig.camera[c], from_seconds(offset_s[c]));
    TextFile file(folder + "/mav0/cam" + std::to_string(c) + "/sensor.yaml");
    file.put(text.c_str());
    file.finish();
  }
  if (imu == nullptr) return;
  Text<4096> text;
  put_imu_yaml(text, imu->noise, imu->intrinsics);
  TextFile file(folder + "/mav0/imu0/sensor.yaml");
  file.put(text.c_str());
  file.finish();
}

void write_camchain(const std::string& folder, const CameraRig& rig, const double* offset_s,
                    const FoundImu* imu) {
  TextFile file(folder + (imu != nullptr ? "/camchain-imucam.yaml" : "/camchain.yaml"));
  for (int c = 0; c < rig.cameras; ++c) {
    const Camera& camera = rig.camera[c];
    file.print("cam%d:\n", c);
    if (imu != nullptr) print_rows(file, "T_cam_imu", camera.T_BC.inverse());
    if (c == 1) print_rows(file, "T_cn_cnm1", rig.T_C1C0);
    print_lens(file, camera);
    if (imu != nullptr) file.print("  timeshift_cam_imu: %.9f\n", offset_s[c]);
    file.print("  rostopic: /cam%d/image_raw\n", c);
  }
  file.finish();
  if (imu != nullptr) write_imu_yaml(folder + "/imu.yaml", *imu);
}

void write_device_file(const std::string& path, const CameraRig& rig, const double* offset_s,
                       const FoundImu& imu) {
  Calibration calibration;
  calibration.cameras = rig.cameras;
  for (int c = 0; c < rig.cameras; ++c) calibration.camera[c] = rig.camera[c];
  calibration.imu = imu.noise;
  calibration.imu_intrinsics = imu.intrinsics;
  calibration.camera_time_offset_ns = from_seconds(offset_s[0]);
  check_sense(calibration, path);
  Text<kCalibrationTextMax> text;
  write_calibration(calibration, text);
  TextFile file(path);
  file.put("# Written by `pirvs calib`.\n");
  file.put(text.c_str());
  file.finish();
}

void write_imu_yaml(const std::string& path, const FoundImu& imu) {
  TextFile file(path);
  Text<4096> text;
  put_imu_yaml(text, imu.noise, imu.intrinsics);
  file.put(text.c_str());
  file.print("update_rate: %g\nrostopic: /imu0\n", imu.noise.rate_hz);
  file.finish();
}

Json camera_json(const CameraResult& result) {
  const Adjustment& a = result.adjustment;
  const Eigen::VectorXd sigma = a.covariance.diagonal().cwiseSqrt();
  Json out;
  for (int c = 0; c < result.rig.cameras; ++c) {
    Json camera = lens_json(result.rig.camera[c], sigma.data() + 8 * c);
    camera["reprojection_px"] = a.rms_px[c];
    camera["held_out_px"] = result.held_out.within_px[c];
    camera["tags"] = a.tags[c];
    out["cam" + std::to_string(c)] = camera;
  }
  if (result.rig.cameras == 2) {
    out["stereo"] = {{"T_C1C0", transform(result.rig.T_C1C0)},
                     {"sigma_rotation_rad", array(sigma.data() + 16, 3)},
                     {"sigma_place_m", array(sigma.data() + 19, 3)},
                     {"baseline_m", result.rig.T_C1C0.p.norm()},
                     {"across_held_out_px", result.held_out.across_px}};
  }
  out["tag_sigma_px"] = a.sigma_px;
  out["outliers"] = a.outliers;
  out["shots"] = {{"used", result.used.size()}, {"seen", result.all.size()}};
  if (result.other_model_px > 0) out["other_model_held_out_px"] = result.other_model_px;
  for (Eigen::Index i = 0; i < a.covariance.rows(); ++i) {
    const Eigen::VectorXd row = a.covariance.row(i);
    out["covariance"].push_back(array(row.data(), int(row.size())));
  }
  return out;
}

ImuIntrinsics intrinsics_of(const ImuCameraResult& r) { return {r.gyro, r.accel, r.b_g, r.b_a}; }

Json imu_json(const ImuCameraResult& r) {
  Json out;
  for (int c = 0; c < r.rig.cameras; ++c) {
    const CameraToImu& camera = r.camera[c];
    Json json = lens_json(r.rig.camera[c], camera.lens_sigma.data());
    json["T_BC"] = transform(camera.T_BC);
    json["sigma_rotation_rad"] = array(camera.sigma.data(), 3);
    json["sigma_place_m"] = array(camera.sigma.data() + 3, 3);
    json["time_offset_s"] = {{"value", camera.offset_s}, {"sigma", camera.sigma[6]}};
    json["time_drift"] = {{"value", camera.drift}, {"sigma", camera.sigma[7]}};
    json["reprojection_px"] = camera.rms_px;
    out["cam" + std::to_string(c)] = json;
  }
  out["imu"] = {{"gyro_matrix", rows(r.gyro)},
                {"gyro_matrix_sigma", rows(r.gyro_sigma)},
                {"accel_matrix", rows(r.accel)},
                {"accel_matrix_sigma", rows(r.accel_sigma)},
                {"gyro_bias_rad_s", array(r.b_g.data(), 3)},
                {"gyro_bias_sigma_rad_s", array(r.b_g_sigma.data(), 3)},
                {"accel_bias_m_s2", array(r.b_a.data(), 3)},
                {"accel_bias_sigma_m_s2", array(r.b_a_sigma.data(), 3)},
                {"gyro_residual_rad_s", r.gyro_rms},
                {"accel_residual_m_s2", r.accel_rms},
                {"gyro_noise_over_density", r.gyro_excess},
                {"accel_noise_over_density", r.accel_excess}};
  out["gravity_in_board"] = array(r.gravity_T.data(), 3);
  out["baseline_m"] = {{"value", r.baseline_m}, {"sigma", r.baseline_sigma_m}};
  out["knot_s"] = r.knot_s;
  out["kept_prior"] = r.unexcited;
  return out;
}

void write_json(const std::string& path, const Json& json) {
  TextFile file(path);
  file.put((json.dump(2) + '\n').c_str());
  file.finish();
}

}  // namespace pirvs::tools
