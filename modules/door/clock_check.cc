#include "modules/door/clock_check.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/math/so3.h"

namespace pirvs {
namespace {

constexpr TimeNs kSpacing_ns = 2'000'000;  // of the samples kept: enough for any body's turning
constexpr size_t kPairsMin = 15;
constexpr double kNoise_rad = 0.002;  // a track this far out of its plane fits half
constexpr int kPasses = 4;

// What decides: frames in a row err alike, so four count as one.
constexpr int kFramesMin = 8, kAlike = 4;
constexpr double kTime_s_min = 0.3;
constexpr double kBetter_min = 0.1, kSigmas = 3;

}  // namespace

void ClockCheck::configure(const Camera* cameras) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  reset();
}

void ClockCheck::reset() {
  history_size_ = 0;
  last_camera_ = -1;
  shift_ = 0;
  motions_.clear();
}

// Not the ImuHistory of tracking: there samples count little while a clock is in doubt, and here
// they decide whether it was set; and thinned out, they reach back as far at any rate of the IMU.
void ClockCheck::add_imu(const ImuSample& sample) {
  if (history_size_ > 0) {
    const ImuSample& newest = history_[(history_size_ - 1) % kHistory];
    if (sample.t - newest.t < kSpacing_ns) return;
  }
  history_[history_size_++ % kHistory] = sample;
}

// Tracks from all over the image; they come in no particular order.
void ClockCheck::see(const Frame& frame, TimeNs before) {
  Motion* const motion = motions_.append();
  if (motion == nullptr) return;
  motion->begin = before;
  motion->end = frame.t;
  motion->camera = frame.camera;
  motion->pairs.clear();
  const Camera& camera = camera_[frame.camera];
  const size_t step = frame.tracks->size() / kPairs + 1;
  for (size_t i = 0; i < frame.tracks->size(); i += step) {
    const Track& track = (*frame.tracks)[i];
    Vec3 before_C, now_C;
    if (track.age == 0 || !camera.unproject(Vec2(track.x_last, track.y_last), before_C) ||
        !camera.unproject(Vec2(track.x, track.y), now_C)) {
      continue;
    }
    (void)motion->pairs.push_back({before_C.cast<float>(), now_C.cast<float>()});
  }
  if (motion->pairs.size() < kPairsMin) motions_.pop_back();
}

// False: not in the history, or in part not measured.
bool ClockCheck::felt_turn(TimeNs begin, TimeNs end, Mat3& R_B1B0) const {
  Vec3 turn_B = Vec3::Zero();
  const size_t oldest = history_size_ > kHistory ? history_size_ - kHistory : 0;
  for (size_t i = history_size_; i > oldest + 1; --i) {
    const ImuSample& after = history_[(i - 1) % kHistory];
    const ImuSample& before = history_[(i - 2) % kHistory];
    if (after.t < end && i == history_size_) return false;
    if (before.t >= end) continue;
    if (after.gap_s > 0) return false;
    const TimeNs from = before.t > begin ? before.t : begin;
    const TimeNs to = after.t < end ? after.t : end;
    const double middle_s = to_seconds(from - before.t) + 0.5 * to_seconds(to - from);
    const double share = middle_s / to_seconds(after.t - before.t);
    turn_B += (before.w_B + share * (after.w_B - before.w_B) - b_g_) * to_seconds(to - from);
    if (before.t > begin) continue;
    R_B1B0 = so3_exp(-turn_B);
    return true;
  }
  return false;
}

// How badly the tracks fit a camera that has turned so and moved in any one direction: 0 to 1.
double ClockCheck::misfit(const Motion& motion, const Mat3& R_B1B0) const {
  const Mat3& R_BC = camera_[motion.camera].T_BC.R;
  const Eigen::Matrix3f R_C1C0 = (R_BC.transpose() * R_B1B0 * R_BC).cast<float>();
  FixedVector<Vec3, kPairs> normals_C;
  for (const Pair& pair : motion.pairs) {
    (void)normals_C.push_back((R_C1C0 * pair.before_C).cross(pair.now_C).cast<double>());
  }
  Vec3 travel_C = Vec3(1, 1, 1).normalized();
  double out = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    // The direction that the normals have least of, by inverse iteration.
    Mat3 A = Mat3::Identity() * 1e-9;
    out = 0;
    for (const Vec3& normal_C : normals_C) {
      const double e = pass == 0 ? 0 : normal_C.dot(travel_C) / kNoise_rad;
      const double fit = 1 / (1 + e * e);
      out += (1 - fit) / static_cast<double>(normals_C.size());
      A += fit * fit * normal_C * normal_C.transpose();
    }
    const Mat3 A_inverse = A.inverse();
    for (int i = 0; i < kPasses; ++i) travel_C = (A_inverse * travel_C).normalized();
  }
  return out;
}

// Takes what is known by now into the sums; the rest waits, what is too old goes.
void ClockCheck::compare() {
  const TimeNs newest = history_[(history_size_ - 1) % kHistory].t;
  size_t kept = 0;
  for (size_t i = 0; i < motions_.size(); ++i) {
    const Motion& motion = motions_[i];
    if (motion.end + shift_ > newest) {
      if (kept != i) motions_[kept] = motion;
      ++kept;
      continue;
    }
    Mat3 R_stamped, R_shifted;
    if (!felt_turn(motion.begin, motion.end, R_stamped) ||
        !felt_turn(motion.begin + shift_, motion.end + shift_, R_shifted)) {
      continue;
    }
    const double better = misfit(motion, R_stamped) - misfit(motion, R_shifted);
    ++compared_;
    time_s_ += to_seconds(motion.end - motion.begin);
    better_ += better;
    better2_ += better * better;
  }
  while (motions_.size() > kept) motions_.pop_back();
}

ClockCheck::Verdict ClockCheck::judge() const {
  if (compared_ < kFramesMin || time_s_ < kTime_s_min) return Verdict::kOpen;
  const double mean = better_ / compared_;
  const double variance = (better2_ / compared_ - mean * mean) * kAlike / compared_;
  if (mean * mean < kSigmas * kSigmas * variance) return Verdict::kOpen;
  if (mean > kBetter_min) return Verdict::kSet;
  return mean < -kBetter_min ? Verdict::kHold : Verdict::kOpen;
}

ClockCheck::Verdict ClockCheck::frame(const Frame& frame, TimeNs shift) {
  const bool follows = frame.camera == last_camera_ && frame.t > last_t_ && shift == shift_;
  const TimeNs before = last_t_;
  last_t_ = frame.t;
  last_camera_ = frame.camera;
  if (shift != shift_) {
    shift_ = shift;
    motions_.clear();
    compared_ = 0;
    time_s_ = better_ = better2_ = 0;
  }
  if (shift == 0) b_g_ = frame.b_g;
  if (shift == 0 || history_size_ == 0) return Verdict::kOpen;
  if (follows) see(frame, before);
  compare();
  return judge();
}

}  // namespace pirvs
