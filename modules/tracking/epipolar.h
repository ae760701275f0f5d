// How far the gyro bias is off, by the epipolar planes of one pair of images.
// In      bearings of the same points from two places of the body; the turn between them as
//         integrated at a bias, with its derivative.
// Out     normal equations over the bias: H step = -g.
// Errors  false: too few bearings; nothing is added.
// Cost    ~10 us a pair of 150 bearings, x86-64.
// Source  Kneip, Lynen, ICCV 2013; He et al., CVPR 2023.
#pragma once

#include "core/store/fixed_vector.h"
#include "modules/imu/preintegration.h"

namespace pirvs {

struct BearingPair {
  Vec3 a_B, b_B;  // each in the axes of B at its own time
};
using BearingPairs = FixedVector<BearingPair, 256>;

// Adds sum over the pairs of (t' (a_B x dR(b_g) b_B))^2, least over the direction t of travel, each
// weighed by Huber's function of its angle over sigma_rad.
bool add_epipolar_planes(const BearingPairs& bearings, const Preintegration& motion,
                         double sigma_rad, Mat3& H, Vec3& g);

// Two axes that span the plane normal to g, by columns.
Mat32 tangent_of(const Vec3& g);

inline constexpr double kHuber_sigma = 2.0;
inline double huber_weight(double e) { return e > kHuber_sigma ? kHuber_sigma / e : 1.0; }

}  // namespace pirvs
