// One calibrated camera: from points in its frame to distorted pixels and back.
// In      p_C in metres (x right, y down, z forward), or distorted pixels.
// Out     uv: distorted pixels, (0,0) = centre of the first pixel; J = d uv / d p_C;
//         bearing_C: unit vector.
// Frames  C: camera; T_BC takes C coordinates to the IMU body B.
// Errors  false: behind the camera (radtan: z <= 0), or beyond the radius up to which the
//         distortion is monotonic, or no ray for this pixel. Outputs are then undefined. A point
//         outside the image is no error: ask in_image().
// Cost    ns, x86-64 at 2.1 GHz (make bench K=camera):  project  with J  unproject
//         radtan                                               9      13         77
//         Kannala-Brandt                                      30      42         69
// Goal    A72 cycles: radtan_project 150 a call, radtan_unproject 550 a call.
// Goal    A72 cycles: fisheye_project 350 a call, fisheye_unproject 550 a call.
// Source  kPinholeRadtan: Brown 1966 as in OpenCV, d = k1 k2 p1 p2.
//         kKannalaBrandt: Kannala, Brandt, PAMI 2006, as in OpenCV fisheye, d = k1 k2 k3 k4;
//         good past 90 degrees off axis.
#pragma once

#include <cstdint>

#include "core/math/se3.h"
#include "core/math/types.h"

namespace pirvs {

enum class CameraModel : uint8_t { kPinholeRadtan, kKannalaBrandt };

struct Camera {
  CameraModel model = CameraModel::kPinholeRadtan;
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  double d[4] = {};
  SE3 T_BC;

  bool project(const Vec3& p_C, Vec2& uv) const;
  bool project(const Vec3& p_C, Vec2& uv, Mat23& J) const;
  bool unproject(const Vec2& uv, Vec3& bearing_C) const;
  bool in_image(const Vec2& uv, double border_px) const;
};

}  // namespace pirvs
