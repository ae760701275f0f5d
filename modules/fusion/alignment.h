// Where SLAM's world lies on the Earth: the heading by Wahba's problem about the vertical, and the
// place, over a window of fixes and of the antenna's places in SLAM's world at the same times.
// In      AlignmentPair, in order of time, all in one W.
// Out     solve(): T_EW, its covariance, the extent of the motion, and how well the fixes agree
//         with it against what they claim. The covariance is scaled by that where they claim more
//         than they hold.
// Frames  E: east, north, up. W: SLAM's world, z up: one angle is unknown, not three.
// Units   m, m/s, rad, ns.
//         locate(): a place by that, before the heading is known.
// Errors  kEmpty: fewer than kPairsMin pairs. A stretch of pairs that does not fit the others is
//         left out, one after the other, as long as more than half of the pairs remain.
// Cost    add ~50 ns; solve ~2 us, more where something is left out. 5 kB.
// Source  PIRVS paper, section IV.D; Wahba, SIAM Review 1965. With one angle, weighted sums give
//         the optimum in closed form (Horn, JOSA A 1987), whatever the number of pairs:
//             yaw = atan2(sum w (b x a)_z, sum w (b x^y a)),   a, b about their weighted means,
//         velocities as vectors of their own, and 1 / sum w |b|^2 is its variance.
#pragma once

#include "core/base/status.h"
#include "core/base/time.h"
#include "core/math/se3.h"
#include "core/store/fixed_vector.h"

namespace pirvs {

struct AlignmentPair {
  TimeNs t = 0;
  Vec3 p_E = Vec3::Zero(), p_W = Vec3::Zero();        // the antenna
  double var_horizontal_m2 = 0, var_vertical_m2 = 0;  // of p_E
  Vec3 v_E = Vec3::Zero(), v_W = Vec3::Zero();        // the antenna's
  double var_velocity_m2_s2 = 0;                      // of v_E; 0: no velocity
};

struct Alignment {
  SE3 T_EW;
  Eigen::Matrix<double, 4, 4> cov = Eigen::Matrix<double, 4, 4>::Zero();  // p_EW, yaw
  double sigma_yaw_rad = 0;
  double span_m = 0;  // extent of the antenna's places
  double misfit = 1;  // rms of residuals over their sigmas: 1 where fixes hold what they claim
  int pairs = 0;      // that it stands on
  int left_out = 0;
};

class AlignmentWindow {
 public:
  static constexpr int kPairsMin = 5;

  // Pairs older than `length` are forgotten.
  void configure(TimeNs length) { length_ = length; }
  void add(const AlignmentPair& pair);
  void clear() { stretches_.clear(); }
  TimeNs span() const {
    return stretches_.empty() ? 0 : stretches_.back().end - stretches_[0].begin;
  }
  Status solve(Alignment& out) const;
  // Where p_W lies in E, as far as that is known: near the middle of the pairs it is, even if the
  // heading is not. kEmpty: no pair.
  Status locate(const Vec3& p_W, Vec3& p_E, Mat3& cov) const;

 private:
  static constexpr int kStretches = 33;  // each longer than length_ / 32

  // Weighted sums over pairs that follow each other.
  struct Sums {
    int pairs = 0;
    double w = 0;                                       // horizontal
    Vec2 a = Vec2::Zero(), b = Vec2::Zero();            // sum w a, sum w b
    double dot = 0, cross = 0, aa = 0, bb = 0;          // sum w a.b, w b x a, w a.a, w b.b
    double v_dot = 0, v_cross = 0, v_aa = 0, v_bb = 0;  // likewise of velocities, not centred
    int velocities = 0;
    double up_w = 0, up_d = 0, up_dd = 0;  // vertical: sum of weights, of a_z - b_z, of its square
    void add(const Sums& other);
  };
  struct Stretch {
    TimeNs begin = 0, end = 0;
    Vec3 p_W_min = Vec3::Zero(), p_W_max = Vec3::Zero();
    Sums sums;
  };
  struct Fit {
    double s = 0, c = 1;
    Vec2 p = Vec2::Zero();
    double up = 0, information = 0;
  };

  // All pairs but those of stretches that do not fit the others.
  struct Chosen {
    bool used[kStretches];
    int all = 0;
    Sums sums;
    Fit fit;
    double cost = 0;
  };

  void choose(Chosen& out) const;
  static int squares(const Sums& sums) { return 3 * sums.pairs + 2 * sums.velocities; }
  static Fit fit(const Sums& sums);
  static double cost(const Sums& sums, const Fit& fit);

  TimeNs length_ = 0;
  FixedVector<Stretch, kStretches> stretches_;
};

}  // namespace pirvs
