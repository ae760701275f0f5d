#include "modules/exposure/auto_exposure.h"

#include <algorithm>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kStop = 2.0;
constexpr double kClear = 1.2;            // more than noise and what moves in the view
constexpr double kSame = 1.1;             // two images that say the same of a small change
constexpr double kAgree = 1.5;            // two images that say the same light, as a factor
constexpr double kFirst_s = 0.004;        // before anything is known
constexpr double kPause_s = 1.0;          // after which what was seen is no longer so
constexpr double kRateDecay = 0.93;       // a frame
constexpr double kBlur_tolerated = 1.25;  // of the limit, before exposure is given up for gain
constexpr double kBlur_regained = 0.75;   // of it, before gain is given up for exposure
constexpr int kRegain_frames = 10;

// How far apart as a factor, 1 or more.
double ratio(double a, double b) { return a > b ? a / b : b / a; }

double power(double base, double exponent) { return exponential(exponent * logarithm(base)); }

double rounded(double value, double step, double min, double max) {
  if (step > 0) value = static_cast<double>(static_cast<int64_t>(value / step + 0.5)) * step;
  return std::clamp(value, min, std::max(min, max));
}

}  // namespace

void AutoExposure::configure(const ExposureParams& params, double focal_px, double period_s) {
  *this = AutoExposure{};
  params_ = params;
  focal_px_ = focal_px;
  period_s_ = period_s;
}

void AutoExposure::retune(const ExposureParams& params) {
  params_ = params;
  setting_ = ExposureSetting{};  // told again
  forget();
}

void AutoExposure::forget() {
  light_count_ = swings_ = direction_ = step_ = 0;
  last_ = 0;
  eager_ = true;
}

void AutoExposure::turn(double rate_rad_s) { rate_rad_s_ = std::max(rate_rad_s_, rate_rad_s); }

// A frame that is lost makes the mean of some periods longer, never shorter.
void AutoExposure::note_time(TimeNs t) {
  const TimeNs oldest = times_[time_count_ % kPeriods];
  const TimeNs last = time_count_ > 0 ? times_[(time_count_ - 1) % kPeriods] : t;
  if (to_seconds(t - last) > kPause_s) {
    time_count_ = 0;
    forget();
  }
  if (time_count_ >= kPeriods) {
    const double mean_s = to_seconds(t - oldest) / kPeriods;
    period_s_ = period_measured_ ? std::min(period_s_, mean_s) : mean_s;
    period_measured_ = true;
  }
  times_[time_count_ % kPeriods] = t;
  ++time_count_;
  if (time_count_ == 2 * kPeriods) time_count_ = kPeriods;
}

// ---- the light ---------------------------------------------------------------------------------

// Where the camera tells it, images of earlier settings are skipped all the same: what was clipped
// in them is a poorer measure than what comes. A camera that never does what it was told is
// believed in the end.
bool AutoExposure::find_taken(const ExposureFrame& frame, double& product) const {
  constexpr double kAsTold = 1.1;
  constexpr int kBelieved = 8;
  product = frame.taken.product();
  if (product > 0) return age_ >= kBelieved || ratio(product, setting_.product()) < kAsTold;
  product = setting_.product();
  return age_ >= static_cast<int>(params_.delay_frames);
}

// The factor that light needs: grey goes with light^(1 / gamma).
double AutoExposure::look(const ExposureFrame& frame) const {
  Histogram histogram;
  for (int i = 0; i < frame.count; ++i) {
    if (frame.images[i].data != nullptr) add(frame.images[i], histogram);
  }
  const double grey = correction(histogram, static_cast<double>(params_.mean_grey),
                                 static_cast<double>(params_.highlights));
  return params_.gamma == 1 ? grey : power(grey, static_cast<double>(params_.gamma));
}

// Flicker: the light goes up and down by more than a little from image to image; and so on, while
// it does so by less.
void AutoExposure::note_swing(double suits) {
  if (swings_ > 0) --swings_;
  if (last_ == 0 || ratio(suits, last_) < (swings_ > 0 ? kSame : kClear)) return;
  const int direction = suits > last_ ? 1 : -1;
  if (direction == -direction_) swings_ = kSwingsRemembered;
  direction_ = direction;
}

void AutoExposure::remember(double suits) {
  light_[light_count_ % kWindow] = 1.0 / suits;
  if (++light_count_ == 2 * kWindow) light_count_ = kWindow;
}

// What suits the mean light of the last images, at most so many.
double AutoExposure::mean_of_last(int images) const {
  const int count = std::min(images, light_count_);
  double sum = 0;
  for (int i = 1; i <= count; ++i) sum += light_[(light_count_ - i) % kWindow];
  return count / sum;
}

// Small steps back and forth follow a slow beat of the flicker.
bool AutoExposure::want(double product) {
  const int step = product > wished_ ? 1 : -1;
  if (step == -step_ && since_step_ < kSwingsRemembered) swings_ = kSwingsRemembered;
  step_ = step;
  since_step_ = 0;
  wished_ = product;
  return true;
}

// An image would have been right with this product. True: there is something to correct.
bool AutoExposure::wish(double suits) {
  note_swing(suits);
  ++since_step_;
  const double before = last_;
  last_ = suits;
  const bool far = ratio(suits, wished_) > kStop;
  if (swings_ > 0) {
    remember(suits);
    if (light_count_ < kSwingsJudged) return false;
    const double mean = mean_of_last(kWindow);
    return ratio(mean, wished_) > kClear && want(mean);
  }
  if (far) {
    const bool agreed = before != 0 && ratio(suits, before) < kAgree;
    if (!agreed && !eager_) return false;
    eager_ = agreed;
    light_count_ = step_ = 0;
    wished_ = suits;
    return true;
  }
  const bool clear = ratio(suits, wished_) > kClear;
  if (clear && before != 0 && ratio(suits, before) < kSame) {
    light_count_ = 0;
    remember(before);
    remember(suits);
    return want(mean_of_last(2));
  }
  remember(suits);
  const double mean = mean_of_last(kAveraged);
  const bool judged = light_count_ >= kJudged;
  return judged && ratio(mean, wished_) > 1.0 + static_cast<double>(params_.band) && want(mean);
}

// ---- exposure and gain -------------------------------------------------------------------------

double AutoExposure::exposure_max() const {
  double max_s = std::min(static_cast<double>(params_.longest_s),
                          period_s_ - static_cast<double>(params_.readout_s));
  const double speed_px_s = focal_px_ * rate_rad_s_;
  const double blur_px = static_cast<double>(params_.blur_px);
  if (max_s * speed_px_s > blur_px) max_s = blur_px / speed_px_s;
  return std::clamp(max_s, range_.min.exposure_s, range_.max.exposure_s);
}

ExposureSetting AutoExposure::split(double product) const {
  constexpr double kNearly = 0.9;  // of a period of flicker: a whole one is worth the difference
  constexpr double kRounding = 1e-6;
  const double max_s = exposure_max();
  ExposureSetting out;
  out.gain = range_.min.gain;
  if (params_.gain > 0) {
    out.gain = std::clamp(static_cast<double>(params_.gain), range_.min.gain, range_.max.gain);
  }
  out.exposure_s = std::min(product / out.gain, max_s);
  if (params_.mains_hz > 0) {
    const double period_s = 0.5 / static_cast<double>(params_.mains_hz);
    const int wanted = static_cast<int>(out.exposure_s / period_s + (1.0 - kNearly));
    const int possible = static_cast<int>(max_s / period_s + kRounding);
    const int periods = std::min(wanted, possible);
    if (periods >= 1) out.exposure_s = periods * period_s;
  }
  if (params_.exposure_s > 0) out.exposure_s = static_cast<double>(params_.exposure_s);
  out.exposure_s =
      rounded(out.exposure_s, range_.step.exposure_s, range_.min.exposure_s, range_.max.exposure_s);
  if (params_.gain == 0) {
    const double gain_max = std::min(static_cast<double>(params_.gain_max), range_.max.gain);
    out.gain = rounded(product / out.exposure_s, range_.step.gain, range_.min.gain, gain_max);
  }
  return out;
}

// Its exposure is too long for the motion, or much shorter than the motion asks for.
bool AutoExposure::blurs() const {
  const double now_s = setting_.exposure_s, could_s = split(wished_).exposure_s;
  if (now_s > kBlur_tolerated * could_s) return true;
  return now_s < kBlur_regained * could_s && age_ >= kRegain_frames;
}

bool AutoExposure::frame(const ExposureFrame& frame, ExposureSetting& out) {
  note_time(frame.t);
  ++age_;
  double product = frame.taken.product();
  bool change = false;
  if (setting_.exposure_s == 0) {
    if (wished_ == 0) wished_ = (product > 0 ? product : kFirst_s) * look(frame);
    change = true;
  } else if (find_taken(frame, product)) {
    change = wish(look(frame) * product);
    change |= blurs();
  }
  rate_rad_s_ *= kRateDecay;
  if (!change) return false;
  const ExposureSetting wanted = split(wished_);
  if (wanted.exposure_s == setting_.exposure_s && wanted.gain == setting_.gain) return false;
  out = setting_ = wanted;
  age_ = 0;
  return true;
}

}  // namespace pirvs
