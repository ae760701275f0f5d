#include "modules/recorder/sensor_yaml.h"

namespace pirvs {
namespace {

void put_list(TextWriter& text, const char* key, const double* numbers, int count) {
  text.put(key).put(": [");
  for (int i = 0; i < count; ++i) text.exact(numbers[i]).put(i + 1 < count ? ", " : "]\n");
}

void put_matrix(TextWriter& text, const char* key, const Mat3& M) {
  double m[9];
  for (int i = 0; i < 9; ++i) m[i] = M(i / 3, i % 3);
  put_list(text, key, m, 9);
}

}  // namespace

void put_camera_yaml(TextWriter& text, const Camera& camera, TimeNs offset) {
  text.put("sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [");
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) text.exact(camera.T_BC.R(i, j)).put(", ");
    text.exact(camera.T_BC.p[i]).put(", ");
  }
  text.put("0, 0, 0, 1]\nresolution: [").number(camera.width).put(", ");
  text.number(camera.height).put("]\ncamera_model: pinhole\nintrinsics: [");
  text.exact(camera.fx).put(", ").exact(camera.fy).put(", ");
  text.exact(camera.cx).put(", ").exact(camera.cy).put("]\ndistortion_model: ");
  text.put(camera.model == CameraModel::kKannalaBrandt ? "equidistant" : "radial-tangential");
  text.put("\ndistortion_coefficients: [");
  for (int i = 0; i < 4; ++i) text.exact(camera.d[i]).put(i < 3 ? ", " : "]\n");
  text.put("timeshift_cam_imu: ").exact(to_seconds(offset)).put("\n");
}

void put_intrinsics(TextWriter& text, const ImuIntrinsics& intrinsics) {
  if (!intrinsics.given()) return;
  put_matrix(text, "gyroscope_matrix", intrinsics.gyro);
  put_list(text, "gyroscope_bias", intrinsics.b_g.data(), 3);
  put_matrix(text, "accelerometer_matrix", intrinsics.accel);
  put_list(text, "accelerometer_bias", intrinsics.b_a.data(), 3);
}

void put_imu_yaml(TextWriter& text, const ImuNoise& noise, const ImuIntrinsics& intrinsics) {
  text.put("sensor_type: imu\nrate_hz: ").exact(noise.rate_hz);
  text.put("\ngyroscope_noise_density: ").exact(noise.gyro_noise);
  text.put("\ngyroscope_random_walk: ").exact(noise.gyro_walk);
  text.put("\naccelerometer_noise_density: ").exact(noise.accel_noise);
  text.put("\naccelerometer_random_walk: ").exact(noise.accel_walk).put("\n");
  put_intrinsics(text, intrinsics);
}

}  // namespace pirvs
