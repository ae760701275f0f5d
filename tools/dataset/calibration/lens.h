// What    The lens models of other people's calibrations, and the nearer of the two that the stack
//         computes (core/camera/camera.h).
// In      A lens: projection, distortion, numbers; the image's size.
// Out     project(): rays to pixels by the model's own formula. fit(): a Camera that sends rays to
//         the same pixels, and how far it is off. rays_of(): by the model's own formula, too.
// Units   pixels, (0,0) at the centre of the first one.
// Errors  project: false outside the model. fit: error_px tells.
// Cost    fit: ~0.1 s. rays_of: ~3 us a pixel.
// Source  Mei, Rives, ICRA 2007 (kOmni, as Kalibr has it); Usenko et al., 3DV 2018 (kDoubleSphere);
//         Khomutenko et al., RA-L 2016 (kEucm); Devernay, Faugeras, MVA 2001 (kFov); OpenCV,
//         calib3d (kRadtan with up to 14 coefficients, kEquidistant).
#pragma once

#include <array>
#include <vector>

#include "core/camera/camera.h"

namespace pirvs::tools {

enum class Projection : uint8_t { kPinhole, kOmni, kDoubleSphere, kEucm };
enum class Distortion : uint8_t { kNone, kRadtan, kEquidistant, kFov };

struct Lens {
  Projection projection = Projection::kPinhole;
  Distortion distortion = Distortion::kNone;
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  // kOmni: xi. kDoubleSphere: xi, alpha. kEucm: alpha, beta.
  double a = 0, b = 0;
  // kRadtan: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y. kEquidistant: k1 k2 k3 k4. kFov: w.
  std::array<double, 14> d = {};

  bool project(const Vec3& p_C, Vec2& uv) const;
};

struct LensFit {
  Camera camera;         // without T_BC
  bool exact = false;    // the stack has this model itself
  double error_px = 0;   // the largest within the ellipse that touches the image's edges
  double corner_px = 0;  // the largest of all pixels; a thirtieth of it counts
};
LensFit fit(const Lens& lens);

// The ray of each pixel, row by row; zero where the lens has none.
std::vector<Vec3> rays_of(const Lens& lens);

}  // namespace pirvs::tools
