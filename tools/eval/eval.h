// What    How far an estimated trajectory is from ground truth: ATE, RPE and tilt.
// In      Two trajectories of the same body B, any two world frames; delta_s of the RPE.
// Out     ATE: translation error after the best rigid alignment (no scale). RPE: drift over
//         delta_s, in the body frame. Tilt: angle between the two directions of gravity in the
//         body frame, not aligned; it says something only where z is up in both worlds. And each
//         matched pose, aligned, for plots.
// Frames  E: world of the estimate. W: world of the truth. R_WE, p_WE: the alignment.
// Units   m, deg, s.
// Errors  fewer than 10 poses inside the truth's time: ok = false, and poses tells how many.
// Cost    ~1 us per pose.
// Source  Horn, JOSA A 1987 / Umeyama, PAMI 1991, eq. 40-43 with scale 1; Sturm et al., IROS 2012.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct EvalPose {
  TimeNs t;
  double t_s;
  Vec3 p_WB;        // estimate, aligned
  Vec4 q_WB;        // estimate, aligned
  Vec3 p_truth_WB;  // truth at that time, interpolated
  Vec4 q_truth_WB;
};

struct Evaluation {
  bool ok = false;
  size_t poses = 0;
  double delta_s = 1.0;
  double duration_s = 0;
  double path_m = 0;
  double ate_rmse_m = 0;
  double ate_std_m = 0;
  double ate_max_m = 0;
  size_t rpe_pairs = 0;
  double rpe_m = 0;
  double rpe_deg = 0;
  double tilt_at_10_s_deg = 0;  // 10 s after the first pose; NaN: not so long
  double tilt_at_end_deg = 0;
  double tilt_max_deg = 0;
  Mat3 R_WE = Mat3::Identity();
  Vec3 p_WE = Vec3::Zero();
  std::vector<EvalPose> matched;
};

Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth, double delta_s);

// The result as one line without a line end.
std::string to_line(const Evaluation& result);

}  // namespace pirvs::tools
