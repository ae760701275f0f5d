#include "tools/sim/motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tools/sim/wave.h"

namespace pirvs::tools {
namespace {

constexpr const char* kNames[] = {"hover", "loop",  "handheld", "vehicle",
                                  "spot",  "ramps", "circuit",  "straight"};
static_assert(std::size(kNames) == size_t(Motion::kCount));

constexpr uint64_t kStream = 6;  // of random numbers, and one more for each motion
constexpr double kHeight_m = 1.6;

double smooth_step(double u) {
  const double s = std::clamp(u, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

// From rest to full speed in ramp_s; what has passed of the motion's own time.
double ramped(double t_s, double ramp_s) {
  if (t_s <= 0) return 0;
  return t_s < ramp_s ? t_s * t_s / (2 * ramp_s) : t_s - ramp_s / 2;
}

SE3 look(const Vec3& p_WB, double yaw, double pitch, double roll) {
  const Eigen::AngleAxisd about_z(yaw, Vec3::UnitZ());
  const Eigen::AngleAxisd about_y(pitch, Vec3::UnitY());
  const Eigen::AngleAxisd about_x(roll, Vec3::UnitX());
  return {(about_z * about_y * about_x).toRotationMatrix(), p_WB};
}

// Each is T_WL at t_s after the standstill, asked for in order of time; below zero it rests.
class Hover {
 public:
  explicit Hover(Random& random)
      : x_(random_wave(random, 0.12, 7, 0.3)),
        y_(random_wave(random, 0.12, 6, 0.3)),
        z_(random_wave(random, 0.06, 5, 0.3)),
        yaw_(random_wave(random, 0.15, 9, 0.3)),
        pitch_(random_wave(random, 0.03, 3, 0.5)),
        roll_(random_wave(random, 0.03, 3.5, 0.5)) {}

  SE3 operator()(double t_s) const {
    constexpr double kClimb_m = 0.7, kClimb_s = 2.5;
    const double s = ramped(t_s, 1.5);
    const double climbed_m = kClimb_m * smooth_step(t_s / kClimb_s);
    const Vec3 p(x_.at(s), y_.at(s), kHeight_m - kClimb_m + climbed_m + z_.at(s));
    return look(p, yaw_.at(s), pitch_.at(s), roll_.at(s));
  }

 private:
  Wave x_, y_, z_, yaw_, pitch_, roll_;
};

class Loop {
 public:
  explicit Loop(Random& random)
      : long_m_(random.uniform(3, 3.8)),
        wide_m_(random.uniform(2.4, 3)),
        lap_s_(random.uniform(12, 14)),
        phase_(random.uniform(0, 2 * M_PI)),
        yaw_(random_wave(random, 0.08, 5, 0.3)),
        pitch_(random_wave(random, 0.06, 4.5, 0.5)),
        roll_(random_wave(random, 0.06, 5.5, 0.5)) {}

  SE3 operator()(double t_s) const {
    const double s = ramped(t_s, 2);
    const double a = 2 * M_PI * s / lap_s_ + phase_;
    const Vec3 p(long_m_ * std::cos(a), wide_m_ * std::sin(a), kHeight_m + 0.4 * std::sin(2 * a));
    // Along the ellipse; unwrapped, since the difference to the angle itself stays small.
    const double along =
        a + M_PI / 2 +
        std::atan2((long_m_ - wide_m_) * std::sin(2 * a) / 2,
                   long_m_ * std::pow(std::sin(a), 2) + wide_m_ * std::pow(std::cos(a), 2));
    return look(p, along + yaw_.at(s), pitch_.at(s), roll_.at(s));
  }

 private:
  double long_m_, wide_m_, lap_s_, phase_;
  Wave yaw_, pitch_, roll_;
};

class Handheld {
 public:
  explicit Handheld(Random& random)
      : x_(random_wave(random, 2.2, 24, 0.1)),
        y_(random_wave(random, 2.2, 24, 0.1)),
        look_about_(random_wave(random, 0.5, 7, 0.3)),
        burst_(random_wave(random, 1, 5, 0)),
        step_phase_(random.uniform(0, 2 * M_PI)),
        yaw_(random_wave(random, 0.03, 1 / 1.3, 0.3)),
        pitch_(random_wave(random, 0.025, 1 / 2.7, 0.3)),
        roll_(random_wave(random, 0.02, 1 / 1.8, 0.3)) {}

  SE3 operator()(double t_s) const {
    constexpr double kStep_Hz = 1.8, kBob_m = 0.02, kSway_m = 0.02;
    const double s = ramped(t_s, 1.5);
    const double moving = smooth_step(t_s / 1.5);
    const double shake = moving * std::pow((1 + burst_.at(s)) / 2, 2);
    const double step = 2 * M_PI * kStep_Hz * s + step_phase_;
    const double yaw = 2 * M_PI / 24 * s + look_about_.at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0);
    const Vec3 p = Vec3(x_.at(s), y_.at(s), kHeight_m + moving * kBob_m * std::sin(step)) +
                   moving * kSway_m * std::sin(step / 2) * left;
    return look(p, yaw + shake * yaw_.at(s), shake * pitch_.at(s), shake * roll_.at(s));
  }

 private:
  Wave x_, y_, look_about_, burst_;
  double step_phase_;
  Wave yaw_, pitch_, roll_;
};

class Vehicle {
 public:
  explicit Vehicle(Random& random)
      : long_m_(random.uniform(8, 10)),
        wide_m_(random.uniform(5, 6.5)),
        angle_(random.uniform(0, 2 * M_PI)),
        speed_m_s_(random.uniform(2.5, 3)),
        heave_(random_wave(random, 0.001, 1 / 7.0, 0.5)),
        pitch_(random_wave(random, 0.0015, 1 / 5.0, 0.5)),
        roll_(random_wave(random, 0.0015, 1 / 6.0, 0.5)) {}

  SE3 operator()(double t_s) {
    constexpr double kCameraHeight_m = 0.5, kPitch_s2_m = 0.006;
    const double before_m_s = speed_at(t_s_);
    const double dt_s = std::max(0.0, t_s - t_s_);
    const double now_m_s = speed_at(t_s);
    constexpr int kSteps = 8;
    for (int i = 0; i < kSteps; ++i) {  // along the ellipse, by its arc
      const double v = before_m_s + (now_m_s - before_m_s) * (i + 0.5) / kSteps;
      angle_ +=
          v * dt_s / kSteps / std::hypot(long_m_ * std::sin(angle_), wide_m_ * std::cos(angle_));
    }
    t_s_ = t_s;
    const double rattle = now_m_s / speed_m_s_;
    const double accel_m_s2 = dt_s > 0 ? (now_m_s - before_m_s) / dt_s : 0;
    const Vec3 p(long_m_ * std::cos(angle_), wide_m_ * std::sin(angle_),
                 kCameraHeight_m + rattle * heave_.at(t_s));
    const double along = std::atan2(wide_m_ * std::cos(angle_), -long_m_ * std::sin(angle_));
    return look(p, along, rattle * pitch_.at(t_s) - kPitch_s2_m * accel_m_s2,
                rattle * roll_.at(t_s));
  }

 private:
  double long_m_, wide_m_, angle_, speed_m_s_;
  double t_s_ = 0;
  Wave heave_, pitch_, roll_;

  // 3 s to full speed, 2.5 s to brake, 1 s at rest: every 14 s.
  double speed_at(double t_s) const {
    constexpr double kEvery_s = 14, kUp_s = 3, kBrake_at_s = 10.5, kBrake_s = 2.5;
    if (t_s <= 0) return 0;
    const double t = std::fmod(t_s, kEvery_s);
    return speed_m_s_ * (smooth_step(t / kUp_s) - smooth_step((t - kBrake_at_s) / kBrake_s));
  }
};

// A vehicle that goes where its wheels roll; the camera is ahead of and above its axle.
class Driven {
 public:
  explicit Driven(Random&) {}

  SE3 operator()(double t_s) {
    constexpr double kStep_s = 1e-3;
    for (; t_s_ + kStep_s <= t_s; t_s_ += kStep_s) go(t_s_ + kStep_s / 2, kStep_s);
    if (t_s > t_s_) go((t_s_ + t_s) / 2, t_s - t_s_);
    t_s_ = std::max(t_s_, t_s);
    const SE3 T_WV = look(p_WV_, yaw_, -slope_, 0);
    return {T_WV.R, T_WV * -kAxle_L};
  }

  static inline const Vec3 kAxle_L = Vec3(-0.25, 0, -0.4);

 protected:
  struct Going {
    double speed_m_s = 0, turn_rad_s = 0, slope_rad = 0;
  };
  virtual ~Driven() = default;
  virtual Going at(double t_s, double way_m) const = 0;

 private:
  Vec3 p_WV_ = Vec3(0, 0, 0.1);
  double yaw_ = 0, slope_ = 0, way_m_ = 0, t_s_ = 0;

  void go(double t_s, double dt_s) {
    const Going going = at(t_s, way_m_);
    slope_ = going.slope_rad;
    const double yaw = yaw_ + going.turn_rad_s * dt_s / 2;
    yaw_ += going.turn_rad_s * dt_s;
    const double flat = std::cos(slope_);
    p_WV_ +=
        going.speed_m_s * dt_s * Vec3(flat * std::cos(yaw), flat * std::sin(yaw), std::sin(slope_));
    way_m_ += going.speed_m_s * dt_s;
  }
};

class Spot final : public Driven {
  using Driven::Driven;
  Going at(double t_s, double) const override {
    constexpr double kTurn_rad_s = 1, kUp_s = 1, kTurns_s = 2 * M_PI * 10 / kTurn_rad_s;
    return {0, kTurn_rad_s * (smooth_step(t_s / kUp_s) - smooth_step((t_s - kTurns_s) / kUp_s)), 0};
  }
};

class Ramps final : public Driven {
  using Driven::Driven;
  Going at(double t_s, double way_m) const override {
    constexpr double kSpeed_m_s = 1.2, kSlope_rad = 0.17, kSlope_m = 6, kBend_m = 9;
    return {kSpeed_m_s * smooth_step(t_s / 2), 0.25 * std::sin(2 * M_PI * way_m / kBend_m),
            kSlope_rad * smooth_step(way_m) * std::sin(2 * M_PI * way_m / kSlope_m)};
  }
};

class Circuit final : public Driven {
  using Driven::Driven;
  Going at(double t_s, double way_m) const override {
    constexpr double kSpeed_m_s = 3, kLong_m = 90, kShort_m = 44.3, kRadius_m = 5;
    constexpr double kArc_m = kRadius_m * M_PI / 2, kHalf_m = kLong_m + kShort_m + 2 * kArc_m;
    const double way = std::fmod(way_m, kHalf_m);
    const bool turns = (way > kLong_m && way < kLong_m + kArc_m) || way > kHalf_m - kArc_m;
    const double speed = kSpeed_m_s * smooth_step(t_s / 4);
    return {speed, turns ? speed / kRadius_m : 0, 0};
  }
};

class Straight final : public Driven {
  using Driven::Driven;
  Going at(double, double) const override { return {1, 0, 0}; }
};

template <class Kind>
Path through(uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB) {
  constexpr double kSpacing_s = 0.04;  // a wave of 3 Hz keeps 87 % of its height
  Random random(seed, kStream);
  Kind kind(random);
  // A knot moves the path up to three knots before it: rest is rest to the end.
  const double still_s = rest_s > 0 ? rest_s + 2.5 * kSpacing_s : 0;
  return Path::through(duration_s, kSpacing_s, [&](double t_s) {
    const SE3 T_WL = kind(std::max(0.0, t_s - still_s));
    return SE3{T_WL.R * R_LB, T_WL.p};
  });
}

}  // namespace

bool find_motion(const std::string& name, Motion& out) {
  for (size_t i = 0; i < size_t(Motion::kCount); ++i) {
    if (name != kNames[i]) continue;
    out = Motion(i);
    return true;
  }
  return false;
}

Vec3 axle_L(const std::string& path) {
  Motion motion = Motion::kHover;
  const bool driven = find_motion(path, motion) && motion >= Motion::kSpot;
  return driven ? Driven::kAxle_L : Vec3(0, 0, -0.4);
}

Path make_motion(Motion motion, uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB) {
  switch (motion) {
    case Motion::kHover:
      return through<Hover>(seed, rest_s, duration_s, R_LB);
    case Motion::kLoop:
      return through<Loop>(seed, rest_s, duration_s, R_LB);
    case Motion::kHandheld:
      return through<Handheld>(seed, rest_s, duration_s, R_LB);
    case Motion::kSpot:
      return through<Spot>(seed, rest_s, duration_s, R_LB);
    case Motion::kRamps:
      return through<Ramps>(seed, rest_s, duration_s, R_LB);
    case Motion::kCircuit:
      return through<Circuit>(seed, rest_s, duration_s, R_LB);
    case Motion::kStraight:
      return through<Straight>(seed, 0, duration_s, R_LB);
    default:
      return through<Vehicle>(seed, rest_s, duration_s, R_LB);
  }
}

}  // namespace pirvs::tools
