#include "tools/run/verdict.h"

#include <algorithm>

#include "tools/info/imu_sense.h"

namespace pirvs::tools {
namespace {

// What the samples themselves say is wrong with them.
std::string wrong_imu(const Recording& recording) {
  const ImuFault fault = find_imu_fault(recording.imu);
  return fault.what.empty() ? "" : fault.what + ": " + fault.what_to_do;
}

std::string why_no_start(const Recording& recording, const RunLog& log) {
  const std::string imu = wrong_imu(recording);
  if (!imu.empty()) return imu;
  constexpr int kTracks_min = 20;
  int most[2] = {0, 0};
  for (const FrameReport& frame : log.frames) {
    for (int c = 0; c < 2; ++c) most[c] = std::max(most[c], frame.tracks[c]);
  }
  const int cameras = recording.calibration.cameras;
  if (std::max(most[0], most[1]) < kTracks_min) {
    return "images without texture: dark, blurred or blank";
  }
  if (cameras == 2 && std::min(most[0], most[1]) < kTracks_min) {
    return most[0] < most[1] ? "cam0 sees no texture" : "cam1 sees no texture";
  }
  for (const Count& count : log.counters) {
    if (count.name == "start_failures" && count.value > log.frames.size() / 2 && cameras == 2) {
      return "the cameras see too little in common, or it does not fit the IMU: T_BS, stamps, "
             "a lens cap?";
    }
  }
  return cameras == 1 ? "too little motion for one camera, or the IMU's axes do not fit it"
                      : "images and IMU do not fit: T_BS, stamps or axes?";
}

}  // namespace

std::string reasons_text(uint16_t reasons) {
  std::string out;
  for (int i = 0; i < int(Reason::kCount); ++i) {
    if ((reasons & bit(Reason(i))) == 0) continue;
    if (!out.empty()) out += '+';
    out += name(Reason(i));
  }
  return out;
}

std::string verdict(const Recording& recording, const RunLog& log) {
  const auto has_pose = [](const FrameReport& frame) { return frame.has_pose; };
  if (std::none_of(log.frames.begin(), log.frames.end(), has_pose)) {
    return "tracking never started: " + why_no_start(recording, log);
  }
  // Once may be a fault that has passed; again and again is what the calibration or the units say.
  for (const Count& count : log.counters) {
    if (count.name != "losses_hopeless" || count.value < 2) continue;
    const std::string imu = wrong_imu(recording);
    return "tracking was given up as hopeless " + std::to_string(count.value) + " times: " +
           (imu.empty() ? "do gyro and images turn against each other? Axes, T_BS, stamps" : imu);
  }
  const FrameReport& last = log.frames.back();
  if (!last.has_pose || last.pose.health == HealthState::kLost) {
    const std::string imu = wrong_imu(recording);
    return "tracking was lost at the end" + (imu.empty() ? "" : ": " + imu);
  }
  // Others pass by themselves.
  if ((last.pose.trust.reasons & bit(Reason::kTurn)) != 0) {
    return "gyro and images turn against each other: axes of the IMU, or T_BS?";
  }
  const uint16_t lasting = bit(Reason::kBlind) | bit(Reason::kRejected) | bit(Reason::kAccelBias) |
                           bit(Reason::kGyroBias) | bit(Reason::kSpeed);
  const uint16_t doubts = last.pose.trust.reasons & lasting;
  if (last.pose.health != HealthState::kTracking || doubts != 0) {
    const std::string reasons = reasons_text(doubts);
    return "the pose is to be doubted at the end: " + (reasons.empty() ? "degraded" : reasons);
  }
  return "";
}

}  // namespace pirvs::tools
