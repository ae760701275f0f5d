// What    Which shots a calibration is made from: those that add to what is known of the rig.
// In      A rig close to the truth; shots with the board's pose.
// Out     Indices of shots, in order of time: each added at least gain_min nats to the information
//         of the rig's unknowns when it was taken, the board's pose marginalized.
// Errors  none; no shots, none chosen.
// Cost    ~0.1 ms a shot, and 5 us per shot and choice.
// Source  Maye, Sommer, Agamennoni, Siegwart, Furgale, RSS 2016 (online self-calibration),
//         greedily.
#pragma once

#include <vector>

#include "tools/calib/camera_adjustment.h"

namespace pirvs::tools {

struct ShotChoice {
  double gain_min_nats = 0.1;
  size_t most = 150;
};

std::vector<size_t> choose_shots(const Target& target, const CameraRig& rig,
                                 const std::vector<PosedShot>& shots, const ShotChoice& how);

}  // namespace pirvs::tools
