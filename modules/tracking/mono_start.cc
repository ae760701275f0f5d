#include "modules/tracking/mono_start.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/math/so3.h"
#include "core/math/square.h"
#include "modules/imu/gravity.h"
#include "modules/tracking/epipolar.h"

namespace pirvs {
namespace {

constexpr int kSightingsMin = 3;
constexpr int kTracksMin = 20;  // that show parallax, or fit
constexpr int kPairGapMax = 4;  // keyframes apart
constexpr double kParallax_rad_min = 0.01;
constexpr double kSigma_px = 1.0;
constexpr double kMisfit_px = 4.0;
constexpr double kResidual_px_max = 1.5;  // rms of a fit
constexpr double kGyroBias_rad_s_max = 0.5;
constexpr double kGyroBiasSigma_rad_s = 0.1;
constexpr double kAccelBiasSigma_m_s2 = 0.2;
constexpr double kDistance_m_min = 0.05;  // nearer points are wrong
constexpr double kWay_m = 0.005;          // vibration, on top of what wheels are told to err
constexpr double kCaution2 = 4.0;         // twice the formal sigma: samples have errors, too

double huber_cost(double e2) {
  constexpr double kLinear_from = kHuber_sigma * kHuber_sigma;
  return e2 <= kLinear_from ? e2 : 2 * kHuber_sigma * std::sqrt(e2) - kLinear_from;
}

MonoStart moved(const MonoStart& at, const Eigen::Matrix<double, MonoStart::kUnknowns, 1>& d) {
  MonoStart out = at;
  out.b_g += d.segment<3>(MonoStart::kBg);
  out.b_a += d.segment<3>(MonoStart::kBa);
  out.v_B0 += d.segment<3>(MonoStart::kVel);
  out.g_B0 += at.g_tangent * d.segment<2>(MonoStart::kGravity);
  out.g_B0 *= kGravity_m_s2 / out.g_B0.norm();
  out.g_tangent = tangent_of(out.g_B0);
  return out;
}

// How frame k's place in B0 moves with the unknowns.
Eigen::Matrix<double, 3, MonoStart::kUnknowns> place_jacobian(const MonoStart& at,
                                                              const Preintegration& motion) {
  Eigen::Matrix<double, 3, MonoStart::kUnknowns> J;
  J.middleCols<3>(MonoStart::kBg) = motion.dp_dbg;
  J.middleCols<3>(MonoStart::kBa) = motion.dp_dba;
  J.middleCols<3>(MonoStart::kVel) = Mat3::Identity() * motion.dt_s;
  J.middleCols<2>(MonoStart::kGravity) = 0.5 * motion.dt_s * motion.dt_s * at.g_tangent;
  return J;
}

}  // namespace

void MonoStarter::configure(const Camera& camera, int index, const ImuNoise& noise,
                            const TrackerParams& params) {
  camera_ = camera;
  T_CB_ = camera.T_BC.inverse();
  index_ = index;
  noise_ = noise;
  params_ = params;
}

Status MonoStarter::solve(const ImuHistory& imu, const Wheels& wheels,
                          const StartKeyframes& keyframes, MonoStart& out) {
  out = MonoStart{};
  gather(keyframes);
  if (frames_.size() < 4 || tracks_.size() < kTracksMin) return Status::kEmpty;
  if (!solve_gyro_bias(imu, out.b_g)) return Status::kStale;
  integrate_all(imu, wheels, out);
  if (drop_still_tracks() < kTracksMin) return Status::kEmpty;
  if (!solve_linear(imu, out)) return Status::kStale;
  for (int round = 0; round < 2; ++round) {
    if (!refine(out) || drop_misfits(out) < kTracksMin) return Status::kStale;
    integrate_all(imu, wheels, out);
  }
  if (!refine(out) || drop_misfits(out) < kTracksMin) return Status::kStale;
  if (out.residual_px > kResidual_px_max || out.b_g.norm() > kGyroBias_rad_s_max) {
    return Status::kStale;
  }
  return out.scale_sigma < params_.start_scale_sigma_max ? Status::kOk : Status::kBadData;
}

void MonoStarter::integrate_all(const ImuHistory& imu, const Wheels& wheels, const MonoStart& at) {
  for (Frame& frame : frames_) {
    frame.motion = integrate(imu, frames_[0].t, frame.t, at.b_g, at.b_a, noise_);
  }
  way_information_.setZero();
  if (wheels.history == nullptr) return;
  way_ =
      integrate(imu, *wheels.history, frames_[0].t, frames_.back().t, at.b_g, noise_, wheels.path);
  if (!way_.holds()) return;
  const Mat3 floor = square(kWay_m) * Mat3::Identity();
  way_information_ = (way_.covariance() + floor).inverse();
}

// By the wheels, less that of the unknowns: zero where they agree.
Vec3 MonoStarter::way_residual(const MonoStart& at) const {
  const SE3 T = pose(at, static_cast<int>(frames_.size()) - 1);
  return way_.way_B0 + way_.dway_dbg * (at.b_g - way_.b_g) - (T.p + T.R * way_.p_BV - way_.p_BV);
}

void MonoStarter::gather(const StartKeyframes& keyframes) {
  frames_.clear();
  tracks_.clear();
  for (const KeyframeMessage& keyframe : keyframes) {
    const int k = static_cast<int>(frames_.size());
    (void)frames_.push_back({keyframe.state.t, Preintegration{}});  // as many as keyframes
    for (const Observation& o : keyframe.observations[index_]) {
      Track* track = std::find_if(tracks_.begin(), tracks_.end(),
                                  [&](const Track& t) { return t.id == o.track; });
      if (track == tracks_.end()) {
        track = tracks_.append();
        if (track == nullptr) continue;  // the older ones say more
        track->id = o.track;
        track->seen.clear();
        track->good = true;
      }
      Sighting sighting{k, Vec2(o.x, o.y), Vec3::Zero()};
      Vec3 f_C;
      if (!camera_.unproject(sighting.uv, f_C)) continue;
      sighting.f_B = camera_.T_BC.R * f_C.normalized();
      (void)track->seen.push_back(sighting);
    }
  }
  for (size_t i = 0; i < tracks_.size();) {
    if (tracks_[i].seen.size() < kSightingsMin) {
      tracks_.erase_unordered(i);
    } else {
      ++i;
    }
  }
}

// A point whose direction does not change has no distance.
int MonoStarter::drop_still_tracks() {
  int good = 0;
  for (Track& track : tracks_) {
    const Sighting& first = track.seen[0];
    const Vec3 f0 = frames_[static_cast<size_t>(first.frame)].motion.dR * first.f_B;
    double angle2_max = 0;
    for (const Sighting& s : track.seen) {
      const Vec3 f = frames_[static_cast<size_t>(s.frame)].motion.dR * s.f_B;
      angle2_max = std::max(angle2_max, (f - f0).squaredNorm());
    }
    track.good = angle2_max > kParallax_rad_min * kParallax_rad_min;
    good += track.good ? 1 : 0;
  }
  return good;
}

// ---- the gyro bias from epipolar planes -------------------------------------------------------

// Over all pairs of near keyframes: sum of (t' (f_i x R_ij(b_g) f_j))^2 over the tracks, least over
// b_g and one direction t for each pair.
bool MonoStarter::solve_gyro_bias(const ImuHistory& imu, Vec3& b_g) const {
  b_g.setZero();
  const int count = static_cast<int>(frames_.size());
  for (int iteration = 0; iteration < 6; ++iteration) {
    Mat3 H = Mat3::Identity() * 1e-9;
    Vec3 g = Vec3::Zero();
    int pairs = 0;
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count && j <= i + kPairGapMax; ++j) {
        const Preintegration motion =
            integrate(imu, frames_[static_cast<size_t>(i)].t, frames_[static_cast<size_t>(j)].t,
                      b_g, Vec3::Zero(), noise_);
        pairs += add_epipolar_pair(i, j, motion, H, g) ? 1 : 0;
      }
    }
    if (pairs < 3) return false;
    const Vec3 step = -(H.inverse() * g);
    if (!step.allFinite()) return false;
    b_g += step * std::min(1.0, 0.2 / (step.norm() + 1e-12));
    if (b_g.norm() > kGyroBias_rad_s_max) return false;
    if (step.norm() < 1e-5) break;
  }
  return true;
}

bool MonoStarter::add_epipolar_pair(int i, int j, const Preintegration& motion, Mat3& H,
                                    Vec3& g) const {
  BearingPairs bearings;
  for (const Track& track : tracks_) {
    const Sighting *a = nullptr, *b = nullptr;
    for (const Sighting& s : track.seen) {
      if (s.frame == i) a = &s;
      if (s.frame == j) b = &s;
    }
    if (a != nullptr && b != nullptr) (void)bearings.push_back({a->f_B, b->f_B});
  }
  return add_epipolar_planes(bearings, motion, kSigma_px / camera_.fx, H, g);
}

// ---- velocity, gravity and points, linear ------------------------------------------------------

bool MonoStarter::solve_linear(const ImuHistory& imu, MonoStart& out) {
  // Gravity's direction to begin with: the mean force, turned into B0.
  Vec3 force_B0 = Vec3::Zero();
  for (const Frame& frame : frames_) {
    const size_t at_frame = imu.first_at(frame.t);
    if (at_frame < imu.end()) force_B0 += frame.motion.dR * imu[at_frame].f_B;
  }
  if (frames_.back().motion.dt_s <= 0 || force_B0.norm() < 1e-3) return false;
  out.g_B0 = -force_B0.normalized() * kGravity_m_s2;
  for (const bool weighted : {false, true}) {
    if (linear_pass(out.g_B0, weighted, out.v_B0, out.g_B0) < 0) return false;
  }
  out.g_tangent = tangent_of(out.g_B0);
  int good = 0;
  for (Track& track : tracks_) {
    for (const Sighting& s : track.seen) {
      const SE3 T = pose(out, s.frame);
      const double along = (T.R * s.f_B).dot(track.p_B0 - T * camera_.T_BC.p);
      track.good = track.good && along > kDistance_m_min;
    }
    good += track.good ? 1 : 0;
  }
  return good >= kTracksMin;
}

// The wheels' way is v0 t + g t^2 / 2 and what rotation and force add; in the units of sightings.
void MonoStarter::add_way(bool weighted, Mat6& H, Vec6& rhs) const {
  constexpr double kDistance_m = 3;  // as a guess
  const Preintegration& m = frames_.back().motion;
  const double sighting = kSigma_px / camera_.fx * (weighted ? 1 : kDistance_m);
  Mat36 B;
  B.leftCols<3>() = Mat3::Identity() * m.dt_s;
  B.rightCols<3>() = Mat3::Identity() * (0.5 * m.dt_s * m.dt_s);
  const Mat63 BtW = square(sighting) * B.transpose() * way_information_;
  H += BtW * B;
  rhs += BtW * (way_.way_B0 + way_.p_BV - m.dR * way_.p_BV - m.dp);
}

// (I - u u') (p - v0 t - g t^2 / 2 - a_k) = 0 for every sighting, u its direction in B0 and a_k the
// place of the camera by rotation and force alone; each point eliminated. Weighted: by the inverse
// distance that the last pass found, which makes a distance an angle. Returns < 0: not solvable.
double MonoStarter::linear_pass(const Vec3& g_start_B0, bool weighted, Vec3& v_B0, Vec3& g_B0) {
  Mat6 H = Mat6::Zero();
  Vec6 rhs = Vec6::Zero();
  for (Track& track : tracks_) {
    if (!track.good) continue;
    Mat3 H_pp = Mat3::Identity() * 1e-9;
    Mat63 H_xp = Mat63::Zero();
    Mat6 H_xx = Mat6::Zero();
    Vec3 b_p = Vec3::Zero();
    Vec6 b_x = Vec6::Zero();
    const double distance = std::max(0.3, track.p_B0.norm());
    const double weight = weighted ? 1.0 / (distance * distance) : 1.0;
    for (const Sighting& s : track.seen) {
      const Preintegration& m = frames_[static_cast<size_t>(s.frame)].motion;
      const Vec3 u = m.dR * s.f_B;
      const Mat3 M = weight * (Mat3::Identity() - u * u.transpose());
      const Vec3 a = m.dp + m.dR * camera_.T_BC.p;
      Mat36 B;
      B.leftCols<3>() = Mat3::Identity() * m.dt_s;
      B.rightCols<3>() = Mat3::Identity() * (0.5 * m.dt_s * m.dt_s);
      const Mat63 BtM = B.transpose() * M;
      H_pp += M;
      H_xp -= BtM;
      H_xx += BtM * B;
      b_p += M * a;
      b_x -= BtM * a;
    }
    const Mat3 inverse = H_pp.inverse();
    track.H_inverse = inverse;
    track.b = b_p;
    track.W.setZero();
    track.W.topRows<6>() = H_xp;
    H += H_xx - H_xp * inverse * H_xp.transpose();
    rhs += b_x - H_xp * inverse * b_p;
  }
  add_way(weighted, H, rhs);
  Vec6 x;
  x << Vec3::Zero(), g_start_B0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Vec3 g = x.tail<3>().normalized() * kGravity_m_s2;
    Eigen::Matrix<double, 6, 5> N = Eigen::Matrix<double, 6, 5>::Zero();
    N.topLeftCorner<3, 3>().setIdentity();
    N.bottomRightCorner<3, 2>() = tangent_of(g);
    Vec6 x0 = Vec6::Zero();
    x0.tail<3>() = g;
    const Eigen::Matrix<double, 5, 5> S = N.transpose() * H * N;
    const Eigen::Matrix<double, 5, 1> step = S.ldlt().solve(N.transpose() * (rhs - H * x0));
    if (!step.allFinite()) return -1;
    x = x0 + N * step;
  }
  v_B0 = x.head<3>();
  g_B0 = x.tail<3>().normalized() * kGravity_m_s2;
  x.tail<3>() = g_B0;
  for (Track& track : tracks_) {
    if (!track.good) continue;
    const Mat63 W = track.W.topRows<6>();
    track.p_B0 = track.H_inverse * (track.b - W.transpose() * x);
  }
  return 0;
}

// ---- all of it, on the image --------------------------------------------------------------------

SE3 MonoStarter::pose(const MonoStart& at, int frame) const {
  const Preintegration& m = frames_[static_cast<size_t>(frame)].motion;
  const Preintegration::Motion motion = m.at(at.b_g, at.b_a);
  return {motion.dR, at.v_B0 * m.dt_s + 0.5 * m.dt_s * m.dt_s * at.g_B0 + motion.dp};
}

double MonoStarter::linearize(const MonoStart& at, MonoStart::Mat& H, Vec& b) {
  H.setZero();
  b.setZero();
  double sum = 0;
  SE3 T_B0B[kFramesMax];
  Eigen::Matrix<double, 3, MonoStart::kUnknowns> J_place[kFramesMax];
  for (size_t k = 0; k < frames_.size(); ++k) {
    T_B0B[k] = pose(at, static_cast<int>(k));
    J_place[k] = place_jacobian(at, frames_[k].motion);
  }
  for (Track& track : tracks_) {
    if (!track.good) continue;
    Mat3 H_pp = Mat3::Identity() * 1e-6;
    track.W.setZero();
    track.b.setZero();
    for (const Sighting& s : track.seen) {
      const SE3& T = T_B0B[s.frame];
      const Vec3 p_B = T.R.transpose() * (track.p_B0 - T.p);
      Vec2 uv;
      Mat23 J_C;
      if (!camera_.project(T_CB_ * p_B, uv, J_C)) continue;
      const Vec2 r = (s.uv - uv) / kSigma_px;
      const double weight = huber_weight(r.norm());
      sum += huber_cost(r.squaredNorm());
      const Mat23 J_B = J_C * T_CB_.R / kSigma_px;
      const Mat23 J_p = J_B * T.R.transpose();
      Eigen::Matrix<double, 2, MonoStart::kUnknowns> J = -J_p * J_place[s.frame];
      J.middleCols<3>(MonoStart::kBg) +=
          J_B * skew(p_B) * frames_[static_cast<size_t>(s.frame)].motion.dR_dbg;
      H_pp += weight * J_p.transpose() * J_p;
      track.W += weight * J.transpose() * J_p;
      track.b += weight * J_p.transpose() * r;
      H += weight * J.transpose() * J;
      b += weight * J.transpose() * r;
    }
    track.H_inverse = H_pp.inverse();
    H -= track.W * track.H_inverse * track.W.transpose();
    b -= track.W * track.H_inverse * track.b;
  }
  const double w_g = 1 / (kGyroBiasSigma_rad_s * kGyroBiasSigma_rad_s);
  const double w_a = 1 / (kAccelBiasSigma_m_s2 * kAccelBiasSigma_m_s2);
  H.diagonal().segment<3>(MonoStart::kBg).array() += w_g;
  H.diagonal().segment<3>(MonoStart::kBa).array() += w_a;
  b.segment<3>(MonoStart::kBg) -= w_g * at.b_g;
  b.segment<3>(MonoStart::kBa) -= w_a * at.b_a;
  const Preintegration& last = frames_.back().motion;
  Eigen::Matrix<double, 3, MonoStart::kUnknowns> J_way = place_jacobian(at, last);
  J_way.middleCols<3>(MonoStart::kBg) -= last.dR * skew(way_.p_BV) * last.dR_dbg + way_.dway_dbg;
  const Vec3 r_way = way_residual(at);
  H += J_way.transpose() * way_information_ * J_way;
  b += J_way.transpose() * way_information_ * r_way;
  sum += r_way.dot(way_information_ * r_way);
  return sum + w_g * at.b_g.squaredNorm() + w_a * at.b_a.squaredNorm();
}

double MonoStarter::cost(const MonoStart& at) const {
  double sum = at.b_g.squaredNorm() / (kGyroBiasSigma_rad_s * kGyroBiasSigma_rad_s) +
               at.b_a.squaredNorm() / (kAccelBiasSigma_m_s2 * kAccelBiasSigma_m_s2);
  const Vec3 r_way = way_residual(at);
  sum += r_way.dot(way_information_ * r_way);
  SE3 T_CB0[kFramesMax];
  for (size_t k = 0; k < frames_.size(); ++k) {
    T_CB0[k] = T_CB_ * pose(at, static_cast<int>(k)).inverse();
  }
  for (const Track& track : tracks_) {
    if (!track.good) continue;
    for (const Sighting& s : track.seen) {
      Vec2 uv;
      if (!camera_.project(T_CB0[s.frame] * track.trial, uv)) return 1e300;
      sum += huber_cost((s.uv - uv).squaredNorm() / (kSigma_px * kSigma_px));
    }
  }
  return sum;
}

bool MonoStarter::refine(MonoStart& out) {
  MonoStart::Mat H;
  Vec b;
  double lambda = 1e-4;
  bool fresh = false;
  double sum = linearize(out, H, b);
  for (int iteration = 0; iteration < 15; ++iteration) {
    MonoStart::Mat damped = H;
    damped.diagonal() *= 1 + lambda;
    const Vec step = damped.ldlt().solve(b);
    if (!step.allFinite()) return false;
    for (Track& track : tracks_) {
      if (track.good) {
        track.trial = track.p_B0 + track.H_inverse * (track.b - track.W.transpose() * step);
      }
    }
    const MonoStart trial = moved(out, step);
    const double sum_trial = cost(trial);
    fresh = sum_trial < sum;
    if (!fresh) {
      lambda *= 10;
      if (lambda > 1e6) break;
      continue;
    }
    const bool converged = sum - sum_trial < 1e-4 * sum;
    out = trial;
    for (Track& track : tracks_) track.p_B0 = track.trial;
    sum = linearize(out, H, b);
    lambda = std::max(1e-9, 0.1 * lambda);
    if (converged) break;
  }
  judge(H, out);
  return true;
}

int MonoStarter::drop_misfits(const MonoStart& at) {
  SE3 T_CB0[kFramesMax];
  for (size_t k = 0; k < frames_.size(); ++k) {
    T_CB0[k] = T_CB_ * pose(at, static_cast<int>(k)).inverse();
  }
  int good = 0;
  for (Track& track : tracks_) {
    for (const Sighting& s : track.seen) {
      Vec2 uv;
      const Vec3 p_C = T_CB0[s.frame] * track.p_B0;
      track.good = track.good && p_C.norm() > kDistance_m_min && camera_.project(p_C, uv) &&
                   (s.uv - uv).norm() < kMisfit_px;
    }
    good += track.good ? 1 : 0;
  }
  return good;
}

void MonoStarter::judge(const MonoStart::Mat& H, MonoStart& out) const {
  out.cov = kCaution2 * H.ldlt().solve(MonoStart::Mat::Identity());
  double farthest = 0;
  out.scale_sigma = 1e9;
  for (const Frame& frame : frames_) {
    const Vec3 p = pose(out, static_cast<int>(&frame - frames_.begin())).p;
    if (p.norm() <= farthest) continue;
    farthest = p.norm();
    const Vec u = place_jacobian(out, frame.motion).transpose() * p / p.norm();
    out.scale_sigma = std::sqrt(std::max(0.0, u.dot(out.cov * u))) / p.norm();
  }
  double squares = 0;
  int sightings = 0;
  out.tracks = 0;
  for (const Track& track : tracks_) {
    if (!track.good) continue;
    ++out.tracks;
    for (const Sighting& s : track.seen) {
      Vec2 uv;
      if (!camera_.project(T_CB_ * (pose(out, s.frame).inverse() * track.p_B0), uv)) continue;
      squares += (s.uv - uv).squaredNorm();
      ++sightings;
    }
  }
  out.residual_px = sightings > 0 ? std::sqrt(squares / sightings) : 1e9;
}

Mat15 mono_start_cov(const MonoStart& start, const Preintegration& motion, const Mat3& R_WB0) {
  Eigen::Matrix<double, 15, MonoStart::kUnknowns> J;
  J.setZero();
  const double t = motion.dt_s;
  const Mat32 tilt = -skew(start.g_B0) * start.g_tangent / start.g_B0.squaredNorm();
  const Vec3 p_B0 = start.v_B0 * t + 0.5 * t * t * start.g_B0 + motion.dp;
  const Vec3 v_B0 = start.v_B0 + t * start.g_B0 + motion.dv;
  J.block<3, 3>(0, MonoStart::kBg) = motion.dR_dbg;
  J.block<3, 2>(0, MonoStart::kGravity) = motion.dR.transpose() * tilt;
  J.middleRows<3>(3) = R_WB0 * place_jacobian(start, motion);
  J.block<3, 2>(3, MonoStart::kGravity) -= R_WB0 * skew(p_B0) * tilt;
  J.block<3, 3>(6, MonoStart::kBg) = R_WB0 * motion.dv_dbg;
  J.block<3, 3>(6, MonoStart::kBa) = R_WB0 * motion.dv_dba;
  J.block<3, 3>(6, MonoStart::kVel) = R_WB0;
  J.block<3, 2>(6, MonoStart::kGravity) = R_WB0 * (t * start.g_tangent - skew(v_B0) * tilt);
  J.block<3, 3>(9, MonoStart::kBg).setIdentity();
  J.block<3, 3>(12, MonoStart::kBa).setIdentity();
  Vec15 floor_sigma;  // the sensors' own errors
  floor_sigma << Vec3::Constant(0.01), Vec3::Constant(0.01), Vec3::Constant(0.02),
      Vec3::Constant(0.002), Vec3::Constant(0.02);
  Mat15 cov = J * start.cov * J.transpose();
  cov.diagonal() += floor_sigma.cwiseAbs2();
  return (0.5 * (cov + cov.transpose())).eval();
}

}  // namespace pirvs
