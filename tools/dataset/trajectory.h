// What    Reads and writes trajectories: TUM files, ASL ground truth, matrix lists.
// In      TUM: t[s] x y z qx qy qz qw. ASL: t[ns],x,y,z,qw,qx,qy,qz[,v x3,b_g x3,b_a x3]. Matrices
//         (PennCOSYVIO): t[s] and the 3 x 4 pose row by row.
// Out     T_WB at each stamp, in order of time; quaternions normalized, x y z w.
// Frames  W, B as the file has them: no alignment here.
// Units   t: ns. t_s: the same in seconds as a double, as evaluation scripts read it. m, m/s,
//         rad/s.
// Errors  InputError with file and line: not a number, NaN, stamps that do not rise, no rows. A
//         last line cut off in the middle is dropped and counted (rows_truncated).
#pragma once

#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/math/types.h"
#include "tools/dataset/stamps.h"

namespace pirvs::tools {

struct TrajectoryPose {
  TimeNs t = 0;
  double t_s = 0;
  Vec3 p_WB = Vec3::Zero();
  Vec4 q_WB = Vec4(0, 0, 0, 1);  // x y z w
  Vec3 v_WB = Vec3::Zero();      // the rest only if Trajectory::full_state
  Vec3 b_g = Vec3::Zero();
  Vec3 b_a = Vec3::Zero();
};

struct Trajectory {
  std::vector<TrajectoryPose> poses;
  bool full_state = false;
  size_t rows_truncated = 0;
};

Trajectory read_trajectory(const std::string& path, const StampRule& rule = {});

// One line of a .tum file, with its line end; seconds with nine decimals, exact to the nanosecond.
std::string tum_line(TimeNs t, const Vec3& p_WB, const Vec4& q_WB);

}  // namespace pirvs::tools
