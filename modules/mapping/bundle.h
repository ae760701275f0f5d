// Visual-inertial bundle adjustment over a few keyframes and their points, in small steps.
// In      states (free or fixed), IMU links and ways of wheels between free neighbours, a prior,
//         points, observations; whether all may tilt as one.
// Out     refined states and points, each point's covariance conditional on all poses, each
//         observation's residual; given the fixed frames, the covariance of the newest frame (added
//         last) and of the oldest free one's pose; how both follow a rigid error of all fixed
//         frames; the tilt that was found, with its covariance.
// Frames  W, B, C; error order of a frame: theta (in B, right), p, v (in W), b_g, b_a.
// Errors  add_*: false when full, nothing is added. solved(): false when no step lowered the cost.
//         errors_known(): false when the system of equations is not positive definite.
// Cost    one iteration of 10 free frames, 400 points, 3000 observations: ~2 ms, x86-64.
// Source  Triggs et al., Bundle adjustment, 2000, section 6 (Schur complement); Forster et al.,
//         T-RO 2017 (IMU residuals); PIRVS paper, section IV.C and its future work;
//         docs/conventions.md, "Levelling".
#pragma once

#include "core/camera/camera.h"
#include "core/store/fixed_vector.h"
#include "modules/map/map_error.h"
#include "modules/mapping/imu_link.h"
#include "modules/mapping/mapping_params.h"
#include "modules/mapping/robust_cost.h"
#include "modules/mapping/wheel_link.h"
#include "modules/mapping/window_prior.h"

namespace pirvs {

// Many methods: the steps of one solver over one set of arrays.
class Bundle {
 public:
  static constexpr int kFreeMax = 12;
  static constexpr int kFramesMax = kFreeMax + 25;
  static constexpr int kPointsMax = 1536;
  static constexpr int kObservationsMax = 24576;
  static constexpr int kSharesMax = 8192;  // point x free frame
  static constexpr int kUnknownsMax = kFreeMax * 15;

  void begin(const Camera* cameras, const ImuNoise& noise, const MappingParams& params);
  int add_frame(const BodyState& state, bool fixed);  // index, or -1; free ones in order of time
  void link(int from, int to, const Preintegration& motion, const WheelPath& way);
  void set_prior(int frame, const WindowPrior& prior);
  // Lets all frames, the fixed ones too, and all points tilt as one, about x and y of W through the
  // place of the oldest free frame, as the IMU links and the prior ask for. `information`: what is
  // known of the fixed frames' tilt.
  void free_tilt(const Mat2& information);
  int add_point(const Vec3& p_W);                                          // index, or -1
  bool add_observation(int point, int frame, int camera, const Vec2& uv);  // to the newest point

  // Does a part of the work; true when all is done.
  bool step();
  bool solved() const { return accepted_ > 0; }

  const BodyState& state(int frame) const { return frames_[frame].state; }
  const Vec3& point(int i) const { return points_[i].p_W; }
  Mat3 point_cov(int i) const { return points_[i].H_inverse; }
  const Mat15& newest_cov() const { return newest_cov_; }
  // The turn by which all was tilted about tilted_at(), and the covariance of what remains.
  const Mat3& tilted() const { return tilted_; }
  const Vec3& tilted_at() const { return pivot_; }
  const Mat2& tilt_cov() const { return tilt_cov_; }
  bool tilt_free() const { return tilt_free_; }
  // Information of vision about the pose of the oldest free frame against all other frames.
  const Mat6& oldest_vision() const { return oldest_vision_; }
  const Mat6& oldest_pose_cov() const { return oldest_pose_cov_; }
  // The covariances above and what follows below hold only if this does.
  bool errors_known() const { return errors_known_; }
  // d (newest state), and d (oldest free pose), by a rigid error (theta, p) of all fixed frames
  // about the place of the oldest free frame: one to one in heading and shift, less in tilt, which
  // the IMU links resist.
  const Mat15x6& newest_follows() const { return newest_follows_; }
  const Mat6& oldest_follows() const { return oldest_follows_; }
  // Residual in sigmas after the last step; infinite for a point behind its camera.
  double residual_sigma(int point, int observation) const;
  int observations(int point) const { return points_[point].count; }
  int points() const { return static_cast<int>(points_.size()); }
  double cost_before() const { return cost_before_; }
  double cost() const { return cost_; }

 private:
  struct Frame {
    BodyState state, trial;
    int unknown;  // first row of its 15, or -1 when fixed
    SE3 T_CW[kCamerasMax], T_CB[kCamerasMax];
  };
  struct Point {
    Vec3 p_W, trial;
    int first, count;              // observations
    int first_share, share_count;  // frames that move it, set by linearize
    Mat3 H_inverse;
    Vec3 b;
  };
  struct ObservedPixel {
    int16_t frame;
    int16_t camera;
    float x, y;
  };
  struct Share {
    int unknown;
    Mat63 W;  // J_pose' J_point, weighted
  };
  enum class Phase : uint8_t { kMeasure, kLinearize, kSolve, kEvaluate, kDone };

  void place_cameras(Frame& frame, const BodyState& state) const;
  void start_iteration();
  void measure_point(const Point& point);
  void linearize_point(Point& point);
  void eliminate_point(const Point& point);
  void keep_oldest_vision();
  void add_block(int at_row, int at_column, const Mat15& block);
  void linearize_links();
  void linearize_wheels();
  void copy_system(double lambda);
  void solve();
  void apply(const double* delta, const Vec2& tilt);
  double cost_at(const Vec3& p_W, const Point& point) const;
  double evaluate_point(Point& point) const;
  double evaluate_links() const;
  double prior_cost(const BodyState& state) const;
  void judge();
  void finish();
  void linearize_tilt();
  Vec2 solve_tilt(double lambda);
  double* row(int i) { return S_ + static_cast<size_t>(i) * kUnknownsMax; }

  Camera camera_[kCamerasMax];
  ImuNoise noise_;
  MappingParams params_;
  FixedVector<Frame, kFramesMax> frames_;
  FixedVector<Point, kPointsMax> points_;
  FixedVector<ObservedPixel, kObservationsMax> observations_;
  FixedVector<Share, kSharesMax> shares_;
  FixedVector<ImuLink, kFreeMax + 1> links_;
  FixedVector<WheelLink, kFreeMax + 1> wheel_links_;
  RobustCost robust_;
  WindowPrior prior_;
  int prior_frame_ = -1;
  int unknowns_ = 0;
  bool tilt_free_ = false;
  Vec3 pivot_ = Vec3::Zero();
  Mat3 tilted_ = Mat3::Identity(), tilted_trial_ = Mat3::Identity();
  Mat2 tilt_known_ = Mat2::Zero(), tilt_cov_ = Mat2::Zero();
  // The borders of the system that belong to a tilt of all: C, D and the right side.
  Mat2 D_ = Mat2::Zero();
  Vec2 g_tilt_ = Vec2::Zero();
  double C_[2][kUnknownsMax], X_[2][kUnknownsMax];  // X = S^-1 C

  Phase phase_ = Phase::kLinearize;
  size_t next_point_ = 0;
  int iteration_ = 0, accepted_ = 0;
  bool errors_known_ = false;
  double lambda_ = 1e-4, cost_ = 0, cost_before_ = 0, cost_trial_ = 0;
  Mat6 oldest_vision_ = Mat6::Zero();
  Mat15 newest_cov_ = Mat15::Identity();
  Mat6 oldest_pose_cov_ = Mat6::Identity(), oldest_follows_ = Mat6::Identity();
  Mat15x6 newest_follows_ = Mat15x6::Zero();
  double S_[kUnknownsMax * kUnknownsMax];
  double factors_[kUnknownsMax * kUnknownsMax];  // of S_, damped or not
  double b_[kUnknownsMax];
  double delta_[kUnknownsMax];
};

}  // namespace pirvs
