// What    What fusion with GNSS has told in a run, as files and as figures.
// In      The fused poses as they came out; the recording and its truth.
// Out     fused.tum: T_EB at every frame and fix, east, north, up about the first good fix, causal.
//         fused.csv: the same with place, sigmas, sources and health. How far from the truth: the
//         error as it is, aligned by nothing, if the recording says where its truth lies.
// Units   m, deg, s.
// Errors  none; without a truth on the Earth, FusedResult::ok is false.
// Source  docs/gnss.md.
#pragma once

#include <string>
#include <vector>

#include "core/math/geodesy.h"
#include "modules/fusion/fused_pose.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

struct FusedResult {
  bool ok = false;
  size_t poses = 0;
  double ate_rmse_m = 0, ate_max_m = 0;  // from the first good fix on
  double aligned_rmse_m = 0;             // of poses with a heading
  double fixes_rmse_m = 0;               // of GNSS alone: accepted or not
  double heading_rmse_deg = 0;           // of poses with a heading
  double nees_position = 0;              // mean, 3 if honest; poses with a heading
  double error_at_end_m = 0;
};

// A late fix tells the newest time again: the last word on each time counts less than the first,
// which is causal, so poses that are not later than one before are left out.
std::vector<FusedPose> in_order(const std::vector<FusedPose>& poses);

FusedResult evaluate_fused(const Recording& recording, const std::vector<FusedPose>& poses,
                           const LocalFrame& frame);

std::string fused_tum(const std::vector<FusedPose>& poses);
std::string fused_csv(const std::vector<FusedPose>& poses);

}  // namespace pirvs::tools
