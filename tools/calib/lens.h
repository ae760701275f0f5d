// What    A camera's intrinsics as eight unknowns, and how a pixel moves with them.
// In      Camera (core/camera/camera.h); p_C in m.
// Out     uv and d uv / d p_C are the product's own projection; J_lens = d uv / d lens.
// Units   lens: fx fy cx cy d0 d1 d2 d3. Both models are linear in each of them.
// Errors  project: false as Camera::project.
// Cost    ~20 ns more than Camera::project.
#pragma once

#include "core/camera/camera.h"

namespace pirvs::tools {

inline constexpr int kLensSize = 8;
using LensVector = Eigen::Matrix<double, kLensSize, 1>;
using Mat28 = Eigen::Matrix<double, 2, kLensSize>;

inline constexpr const char* kLensNames[kLensSize] = {"fx", "fy", "cx", "cy",
                                                      "d0", "d1", "d2", "d3"};

LensVector lens_of(const Camera& camera);
void set_lens(const double* lens, Camera& camera);

bool project(const Camera& camera, const Vec3& p_C, Vec2& uv, Mat23& J, Mat28& J_lens);

}  // namespace pirvs::tools
