#include "modules/door/imu_guard.h"

#include <algorithm>
#include <cmath>

namespace pirvs {
namespace {

// Beyond what any IMU that we might carry measures (4000 deg/s, 32 g): a broken transfer.
constexpr double kRate_rad_s_max = 75.0;
constexpr double kForce_m_s2_max = 320.0;
constexpr double kFullScale = 0.995;  // of the range: converters clip a few counts early

// Vibration is not spikes: kSpread times what samples differ by is usual. One that stands out alone
// must not raise that: it counts as half the limit at most, of some 32 samples.
constexpr double kSpread = 4, kSpreadGain = 1.0 / 32;

double largest(const Vec3& v) { return v.cwiseAbs().maxCoeff(); }

// On some axis b lies beyond `limit` from both a and c, which agree far better.
bool sticks_out(const Vec3& a, const Vec3& b, const Vec3& c, double limit) {
  for (int i = 0; i < 3; ++i) {
    const double before = std::abs(b[i] - a[i]), after = std::abs(b[i] - c[i]);
    const double least = before < after ? before : after;
    if (least > limit && std::abs(c[i] - a[i]) < 0.5 * least) return true;
  }
  return false;
}

}  // namespace

void ImuGuard::configure(const DoorParams& params) {
  *this = ImuGuard{};
  params_ = params;
  rate_limit_ = static_cast<double>(params.spike_rad_s);
  force_limit_ = static_cast<double>(params.spike_m_s2);
  break_ = from_seconds(static_cast<double>(params.break_s));
  bridge_ = from_seconds(static_cast<double>(params.bridge_s));
  gap_ = from_seconds(static_cast<double>(params.gap_s));
  clock_step_ = from_seconds(static_cast<double>(params.clock_step_s));
}

bool ImuGuard::impossible(const ImuSample& raw, DoorLosses& losses) {
  const double rate = largest(raw.w_B), force = largest(raw.f_B);
  if (!is_stamp(raw.t)) {
    losses.add(DoorLoss::kImuStampImpossible);
  } else if (!raw.w_B.allFinite() || !raw.f_B.allFinite()) {
    losses.add(DoorLoss::kImuNotFinite);
  } else if (rate > kRate_rad_s_max || force > kForce_m_s2_max) {
    losses.add(DoorLoss::kImuOutOfRange);
  } else if (rate >= kFullScale * static_cast<double>(params_.gyro_range_rad_s) ||
             force >= kFullScale * static_cast<double>(params_.accel_range_m_s2)) {
    losses.add(DoorLoss::kImuSaturated);
  } else {
    const bool equal = raw.w_B == raw_.w_B && raw.f_B == raw_.f_B;
    equal_ = equal ? equal_ + 1 : 1;
    raw_ = raw;
    if (equal_ < params_.stuck_samples) return false;
    losses.add(DoorLoss::kImuStuck);
  }
  return true;
}

void ImuGuard::note_spread(const ImuSample& before, const ImuSample& raw) {
  const auto note = [](double difference, double least, double& spread2, double& limit) {
    const double counts = std::min(difference, 0.5 * limit);
    spread2 += kSpreadGain * (counts * counts - spread2);
    limit = std::max(least, kSpread * std::sqrt(spread2));
  };
  note(largest(raw.w_B - before.w_B), static_cast<double>(params_.spike_rad_s), rate_spread2_,
       rate_limit_);
  note(largest(raw.f_B - before.f_B), static_cast<double>(params_.spike_m_s2), force_spread2_,
       force_limit_);
}

// Old samples are dropped; when they go on rising for long enough, the clock has been set back and
// the stream begins anew. If they catch up before that, it may have been, too.
bool ImuGuard::backwards(const ImuSample& raw, DoorLosses& losses) {
  if (!has_last_ || raw.t > last_.t) {
    const TimeNs step = is_back_ ? back_begin_ - last_.t - period_ : 0;
    if (step < -clock_step_ && back_last_ - back_begin_ > -step / 2) next_step_ = step;
    is_back_ = false;
    return false;
  }
  if (!is_back_ || raw.t <= back_last_) back_begin_ = raw.t;
  is_back_ = true;
  back_last_ = raw.t;
  if (raw.t - back_begin_ < break_) {
    losses.add(DoorLoss::kImuBackwards);
    return true;
  }
  losses.add(DoorLoss::kImuClockBack);
  next_step_ = back_begin_ - last_.t - period_;
  is_back_ = false;
  has_last_ = false;
  why_doubted_ = Doubt::kNone;
  next_is_broken_ = true;
  return false;
}

bool ImuGuard::jumps(const ImuSample& a, const ImuSample& b) const {
  return largest(b.w_B - a.w_B) > rate_limit_ || largest(b.f_B - a.f_B) > force_limit_;
}

ImuGuard::Doubt ImuGuard::doubt(const ImuSample& raw) const {
  if (!has_last_) return Doubt::kNone;
  if (raw.t - last_.t > break_) return Doubt::kStamp;
  return jumps(last_, raw) ? Doubt::kValue : Doubt::kNone;
}

bool ImuGuard::confirmed_by(const ImuSample& next) const {
  if (why_doubted_ == Doubt::kStamp) return next.t > doubted_.t && next.t - doubted_.t < break_;
  return !sticks_out(last_.w_B, doubted_.w_B, next.w_B, rate_limit_) &&
         !sticks_out(last_.f_B, doubted_.f_B, next.f_B, force_limit_);
}

void ImuGuard::accept(const ImuSample& sample, DoorLosses& losses) {
  GoodSample good{sample, next_is_broken_, next_step_};
  good.sample.gap_s = 0;
  if (has_last_) {
    const TimeNs dt = sample.t - last_.t;
    if (dt > gap_) {
      losses.add(DoorLoss::kImuGap);
      good.sample.gap_s = static_cast<float>(to_seconds(dt));
    } else {
      period_ = dt;
    }
    if (dt - period_ > clock_step_) good.step += dt - period_;
    good.broken = good.broken || dt > bridge_;
  }
  if (good.broken) losses.add(DoorLoss::kStreamBroken);
  next_is_broken_ = false;
  next_step_ = 0;
  last_ = sample;
  has_last_ = true;
  (void)good_.push_back(good);  // at most the doubted one and the one that confirms it
}

void ImuGuard::put(const ImuSample& raw, DoorLosses& losses) {
  const ImuSample before = raw_;
  if (impossible(raw, losses) || backwards(raw, losses)) return;
  note_spread(before, raw);
  if (why_doubted_ != Doubt::kNone && raw.t == doubted_.t) {
    losses.add(DoorLoss::kImuBackwards);
    return;
  }
  if (why_doubted_ != Doubt::kNone && confirmed_by(raw)) {
    accept(doubted_, losses);
    why_doubted_ = Doubt::kNone;
  }
  finish(losses);
  if (backwards(raw, losses)) return;
  why_doubted_ = doubt(raw);
  if (why_doubted_ == Doubt::kNone) {
    accept(raw, losses);
  } else {
    doubted_ = raw;
  }
}

void ImuGuard::finish(DoorLosses& losses) {
  if (why_doubted_ == Doubt::kValue) losses.add(DoorLoss::kImuSpike);
  if (why_doubted_ == Doubt::kStamp) losses.add(DoorLoss::kImuStampAhead);
  why_doubted_ = Doubt::kNone;
}

bool ImuGuard::get(GoodSample& out) {
  if (good_.empty()) return false;
  out = good_[0];
  good_.erase_unordered(0);
  return true;
}

}  // namespace pirvs
