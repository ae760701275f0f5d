#include "modules/standstill/standstill.h"

#include <algorithm>
#include <cmath>

#include "modules/imu/gravity.h"

namespace pirvs {

namespace {

constexpr int kCellsMin = 8;           // fewer that vote: nothing is seen
constexpr double kShareToRest = 0.35;  // of the cells, more than this stand
constexpr double kShareToLeave = 0.2;  // what moves before the camera may grow meanwhile
constexpr double kLeft_s = 0.3;        // so long it counts that a track left its place
constexpr double kSlide_px = 0.5;      // of a track at rest
constexpr double kTrackSettle_s = 5;   // a track's place follows its slow drift of itself
constexpr double kImuSettle_s = 20;    // and the IMU's means the wander of its biases
constexpr double kPlatform_m_s = 0.5, kPlatform_rad = 0.1;  // what a knock or a bias does not reach
constexpr double kMoment_s = 0.6;
constexpr double kShaken_s = 0.1;     // nor what motors shake, which does not sum up
constexpr double kBias_rad_s = 0.12;  // a gyro wanders no farther while the device rests

}  // namespace

void StandstillDetector::reset() {
  count_ = 0;
  imu_end_ = 0;
  cells_still_ = cells_ = standing_ = 0;
  left_ = 0;
  w_sigma_ = f_sigma_ = 1e9;
  patience_s_ = rest_s_ = 0;
  pushed_ = false;
  rate_step_ = 0;
  since_step_ = 0;
  moved_along_ = false;
}

// Keeps where the track stays: a place that it leaves is given up for the one where it is now.
void StandstillDetector::follow(const Track& track, double dt_s, double stay_px, Stay& stay) {
  if (stay.still_s < 0) {  // its second image
    stay.x = track.x_last;
    stay.y = track.y_last;
    stay.still_s = 0;
  }
  const double dx = track.x - stay.x, dy = track.y - stay.y;
  if (dx * dx + dy * dy <= stay_px * stay_px) {
    stay.still_s += static_cast<float>(dt_s);
    const double gain = dt_s / kTrackSettle_s;
    stay.x += static_cast<float>(gain * dx);
    stay.y += static_cast<float>(gain * dy);
    return;
  }
  stay.x = track.x;
  stay.y = track.y;
  stay.still_s = 0;
  stay.moves = static_cast<uint8_t>(std::min(stay.moves + 1, 254));
}

// A standing track has slid when it stands elsewhere than before while the device rests. Otherwise
// its place becomes the one to be compared with.
void StandstillDetector::settle(const Track& track, bool stood, Stay& stay) const {
  const float dx = track.x - stay.x_stood, dy = track.y - stay.y_stood;
  if (stood && !(at_rest() && dx * dx + dy * dy > kSlide_px * kSlide_px)) return;
  if (at_rest() && (stood || stay.moves > 0)) {
    stay.moves = kSlid;
    return;
  }
  stay.x_stood = stay.x;
  stay.y_stood = stay.y;
  stay.moves = 0;
}

// A track votes once it has moved or has stood for long enough, a cell by the majority of its
// tracks: what attracts many tracks has no more votes than its share of the image.
void StandstillDetector::add_tracks(const Camera& camera, int c, const Tracks& tracks,
                                    double dt_s) {
  int votes[kColumns * kRows] = {};
  bool voted[kColumns * kRows] = {};
  for (const Track& track : tracks) {
    if (track.age == 0) continue;
    Stay& stay = stays_[c][track];
    const bool stood = stands(stay);
    follow(track, dt_s, params_.image_px, stay);
    if (stands(stay)) {
      settle(track, stood, stay);
      ++standing_;
    } else if (stay.moves == 0) {
      continue;
    }
    left_ += stood && !stands(stay) ? 1 : 0;
    const int column =
        std::clamp(static_cast<int>(track.x) * kColumns / camera.width, 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(track.y) * kRows / camera.height, 0, kRows - 1);
    votes[row * kColumns + column] += stands(stay) ? 1 : -1;
    voted[row * kColumns + column] = true;
  }
  for (int i = 0; i < kColumns * kRows; ++i) {
    cells_ += voted[i] ? 1 : 0;
    cells_still_ += votes[i] > 0 ? 1 : 0;
  }
}

void StandstillDetector::take_means(const ImuHistory& imu) {
  const size_t window = static_cast<size_t>(params_.window_samples);
  const size_t end = imu.end(), begin = end - std::min(end - imu.begin(), window);
  count_ = static_cast<int>(end - begin);
  if (count_ == 0) return;
  // Summed from the last multiple of `window` on, then what is older: sample n always has the same
  // place in the sum.
  const auto for_each = [&](auto&& visit) {
    const size_t turn = end - end % window;
    for (size_t i = turn; i < end; ++i) visit(imu[i]);
    for (size_t i = begin; i < turn; ++i) visit(imu[i]);
  };
  w_mean_.setZero();
  f_mean_.setZero();
  for_each([&](const ImuSample& sample) {
    w_mean_ += sample.w_B;
    f_mean_ += sample.f_B;
  });
  w_mean_ /= count_;
  f_mean_ /= count_;
  double w2 = 0, f2 = 0;
  for_each([&](const ImuSample& sample) {
    w2 += (sample.w_B - w_mean_).squaredNorm();
    f2 += (sample.f_B - f_mean_).squaredNorm();
  });
  w_sigma_ = std::sqrt(w2 / count_);
  f_sigma_ = std::sqrt(f2 / count_);
  Vec3 w_sum = Vec3::Zero(), f_sum = Vec3::Zero();
  const size_t first = std::max(imu_end_, imu.begin());
  for (size_t i = first; i < end; ++i) {
    w_sum += imu[i].w_B;
    f_sum += imu[i].f_B;
  }
  const int since = static_cast<int>(end - first);
  since_step_ = std::min(since_step_ + since, count_);
  w_last_ = since > 0 ? Vec3(w_sum / since) : w_mean_;
  f_last_ = since > 0 ? Vec3(f_sum / since) : f_mean_;
  imu_end_ = end;
}

bool StandstillDetector::imu_quiet() const {
  const bool stepped = at_rest() && since_step_ < count_;  // within the window
  return count_ >= static_cast<int>(params_.window_samples) &&
         (stepped || w_sigma_ < params_.gyro_rad_s) && f_sigma_ < params_.accel_m_s2 &&
         std::fabs(f_mean_.norm() - kGravity_m_s2) < params_.gravity_m_s2;
}

bool StandstillDetector::as_expected(const Expected& expected) const {
  return !expected.known || ((w_mean_ - expected.w_B).norm() < params_.rate_rad_s &&
                             (f_mean_ - expected.f_B).norm() < params_.force_m_s2);
}

// A picture that stands beats a gyro that steps: had the device turned, the picture would have
// moved, or gravity, were all that is seen turned along. About the vertical that cannot be told:
// what is small is taken for the bias.
bool StandstillDetector::gyro_steps() const {
  return (w_last_ - w_rest_).norm() >= 0.5 * params_.rate_rad_s &&
         (w_last_ - w_begin_).norm() < kBias_rad_s &&
         (f_last_ - f_rest_).norm() < 0.5 * params_.force_m_s2;
}

// At rest any other change against what the IMU settled on is a motion: of the device, or of the
// device with all that it sees.
bool StandstillDetector::stays() const {
  return (w_last_ - w_rest_).norm() < 0.5 * params_.rate_rad_s &&
         (f_last_ - f_rest_).norm() < 0.5 * params_.force_m_s2;
}

// Rest has ended by the IMU alone, the picture still stands, but for moments in which tracks are
// lost that are looked for where the IMU says.
void StandstillDetector::note_push(bool image_still, double dt_s) {
  unstill_s_ = image_still ? 0 : unstill_s_ + dt_s;
  if (unstill_s_ > kMoment_s) pushed_ = false;
  if (!pushed_ || !image_still) return;
  v_pushed_ += dt_s * (f_last_ - f_rest_);
  turn_pushed_ += dt_s * (w_last_ - w_rest_);
  moved_along_ = moved_along_ || v_pushed_.norm() > kPlatform_m_s + kShaken_s * f_sigma_ ||
                 turn_pushed_.norm() > kPlatform_rad + kShaken_s * w_sigma_;
}

void StandstillDetector::judge(const ImuHistory& imu, double dt_s, const Expected& expected) {
  take_means(imu);
  const double still_share = cells_ >= kCellsMin ? static_cast<double>(cells_still_) / cells_ : 0.0;
  cells_ = cells_still_ = 0;
  const bool was_at_rest = at_rest();
  const bool image_still =
      was_at_rest ? still_share > kShareToLeave && left_ < standing_ : still_share > kShareToRest;
  left_ *= std::max(0.0, 1 - dt_s / kLeft_s);
  standing_ = 0;
  rate_step_ = 0;
  if (was_at_rest && image_still && gyro_steps()) {
    rate_step_ = (w_last_ - w_rest_).norm();
    w_rest_ = w_last_;
    since_step_ = 0;
  }
  if (!image_still || !imu_quiet() || (was_at_rest && !stays())) {
    if (was_at_rest && image_still) {
      pushed_ = true;
      v_pushed_.setZero();
      turn_pushed_.setZero();
    }
    note_push(image_still, dt_s);
    rest_s_ = patience_s_ = 0;
    return;
  }
  if (was_at_rest) {
    rest_s_ += dt_s;
    const double gain = std::min(1.0, dt_s / kImuSettle_s);
    w_rest_ += gain * (w_last_ - w_rest_);
    f_rest_ += gain * (f_last_ - f_rest_);
    return;
  }
  note_push(image_still, dt_s);
  patience_s_ += dt_s;
  const bool doubtful = !as_expected(expected) || (pushed_ && !stays());
  if (doubtful && patience_s_ < params_.patience_s) return;
  rest_s_ = params_.image_s;
  pushed_ = false;
  w_rest_ = w_begin_ = w_mean_;
  f_rest_ = f_mean_;
}

}  // namespace pirvs
