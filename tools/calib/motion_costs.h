// What    Costs of the camera-to-IMU adjustment, over a spline: an IMU sample, an image, a prior.
// In      Unknowns in the order of each comment; rotations as solver.h has them.
// Out     Residuals of sigma 1 with analytic derivatives.
// Frames  T: the board; B: the accelerometer's place and axes (its matrix is lower triangular).
//         measured = matrix * true + bias. Times on the IMU's clock: t_imu = t_camera + offset +
//         drift * (t_camera - middle).
// Source  Furgale, Rehder, Siegwart, IROS 2013; Rehder, Nikolic, Schneider, Hinzmann, Siegwart,
//         ICRA 2016 (scale and misalignment).
#pragma once

#include <ceres/sized_cost_function.h>

#include "tools/calib/frame_factor.h"
#include "tools/calib/spline.h"

namespace pirvs::tools {

// Lower triangle by rows: 00 10 11 20 21 22.
Mat3 lower_triangular(const double* m);

struct ImuReading {
  Vec3 w_B, f_B;
  double gyro_sigma, accel_sigma;
  SplineBasis basis;
  double bias_share;  // of the later bias knot
};

// Six q, six p; direction of gravity in T (unit); gyro matrix (9, by rows), accelerometer matrix
// (6); gyro bias before and after, accelerometer bias before and after.
class ImuCost final
    : public ceres::SizedCostFunction<6, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3, 3, 3, 9, 6, 3, 3, 3, 3> {
 public:
  explicit ImuCost(const ImuReading& reading) : reading_(reading) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  ImuReading reading_;
};

// Six q, six p; q and p of T_BC; offset s and drift; lens.
class FrameCost final : public ceres::SizedCostFunction<kFrameSize, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3,
                                                        3, 4, 3, 2, kLensSize> {
 public:
  // t0_s: of the segment's start on the IMU's clock; t_camera_s, since_middle_s: of the image.
  FrameCost(const FrameFactor& factor, double t_camera_s, double since_middle_s, double t0_s,
            double dt_s)
      : factor_(factor),
        t_camera_s_(t_camera_s),
        since_middle_s_(since_middle_s),
        t0_s_(t0_s),
        dt_s_(dt_s) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  FrameFactor factor_;
  double t_camera_s_, since_middle_s_, t0_s_, dt_s_;
};

// A bias walks from one knot to the next.
class WalkCost final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit WalkCost(double sigma) : sigma_(sigma) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  double sigma_;
};

}  // namespace pirvs::tools
