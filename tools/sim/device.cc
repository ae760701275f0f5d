#include "tools/sim/device.h"

#include "core/math/so3.h"

namespace pirvs::tools {
namespace {

SE3 transform(const double (&m)[12]) {
  SE3 T;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.R(i, j) = m[4 * i + j];
    T.p[i] = m[4 * i + 3];
  }
  T.R = orthonormalized(T.R);
  return T;
}

// Camera axes (right, down, forward) in look axes (forward, left, up).
Mat3 look_from_camera() {
  Mat3 R_LC;
  R_LC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_LC;
}

Device euroc() {
  Device device{"euroc", {}, 20, {}};
  Camera& left = device.calibration.camera[0];
  left = {CameraModel::kPinholeRadtan,
          752,
          480,
          458.654,
          457.296,
          367.215,
          248.375,
          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
          transform({0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
                     0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
                     -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949})};
  Camera& right = device.calibration.camera[1];
  right = {CameraModel::kPinholeRadtan,
           752,
           480,
           457.587,
           456.134,
           379.999,
           255.238,
           {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05},
           transform({0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
                      0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,
                      -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038})};
  device.calibration.imu = {1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-3, 200};
  device.R_LB = look_from_camera() * left.T_BC.R.transpose();
  return device;
}

struct Lens {
  double fx, fy, cx, cy;
  double d[4];
};

// Both cameras look along x; no assembly is perfect: half a degree between the lenses.
Device side_by_side(const char* name, CameraModel model, int width, int height, double rate_hz,
                    double half_baseline_m, const Lens (&lenses)[2]) {
  Device device{name, {}, rate_hz, Mat3::Identity()};
  const Mat3 R_LC = look_from_camera();
  for (int c = 0; c < 2; ++c) {
    const Lens& lens = lenses[c];
    const double side = c == 0 ? 1 : -1;
    Camera& camera = device.calibration.camera[c];
    camera = {model, width, height, lens.fx, lens.fy, lens.cx, lens.cy, {}, {}};
    for (int i = 0; i < 4; ++i) camera.d[i] = lens.d[i];
    camera.T_BC.R = R_LC * so3_exp(Vec3(0.002, -0.004, 0.003) * side);
    camera.T_BC.p = Vec3(0.018, half_baseline_m * side, 0.006);
  }
  device.calibration.imu = {2.0e-4, 2.5e-5, 2.2e-3, 1.0e-3, 200};
  return device;
}

Device ironsides() {
  const Lens lenses[2] = {{276.4, 276.2, 321.7, 238.1, {-0.0105, 0.0031, -0.0009, 0.0001}},
                          {276.9, 276.8, 317.2, 241.6, {-0.0105, 0.0031, -0.0010, 0.0001}}};
  return side_by_side("ironsides", CameraModel::kKannalaBrandt, 640, 480, 60, 0.0325, lenses);
}

Device tumvi() {
  const Lens lenses[2] = {{190.98, 190.97, 254.93, 256.90, {0.00348, 0.00072, -0.00205, 0.00020}},
                          {190.44, 190.43, 252.60, 254.92, {0.00340, 0.00177, -0.00266, 0.00033}}};
  return side_by_side("tumvi", CameraModel::kKannalaBrandt, 512, 512, 20, 0.0505, lenses);
}

Device t265() {
  const Lens lenses[2] = {{286.2, 286.3, 420.9, 403.7, {-0.00806, 0.04319, -0.03986, 0.00689}},
                          {285.8, 285.9, 426.3, 397.2, {-0.00741, 0.04238, -0.03922, 0.00672}}};
  return side_by_side("t265", CameraModel::kKannalaBrandt, 848, 800, 30, 0.032, lenses);
}

Device oakd() {
  const Lens lenses[2] = {{799.3, 799.1, 646.2, 396.4, {-0.0523, 0.0618, 0.0004, -0.0007}},
                          {801.6, 801.5, 634.8, 405.1, {-0.0517, 0.0609, -0.0003, 0.0005}}};
  return side_by_side("oakd", CameraModel::kPinholeRadtan, 1280, 800, 30, 0.0375, lenses);
}

}  // namespace

const Device* find_device(const std::string& name) {
  static const Device devices[] = {euroc(), ironsides(), tumvi(), t265(), oakd()};
  for (const Device& device : devices) {
    if (name == device.name) return &device;
  }
  return nullptr;
}

}  // namespace pirvs::tools
