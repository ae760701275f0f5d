#include "tools/calib/flight_check.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// Time offset; turn of the rig; gyro bias; turn of the right camera; its place; focal length of
// both, of the right one alone.
enum Unknown { kTime = 0, kTurn = 1, kBias = 4, kRight = 7, kPlace = 10, kFocal = 13, kOther = 14 };
constexpr int kN = 15;
using VecN = Eigen::Matrix<double, kN, 1>;
using MatN = Eigen::Matrix<double, kN, kN>;

constexpr double kPriorSigma[kN] = {0.05, 0.1,  0.1,  0.1,  0.05, 0.05, 0.05, 0.05,
                                    0.05, 0.05, 1e-3, 1e-3, 1e-3, 0.1,  0.02};
constexpr double kStep[kN] = {1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4,
                              1e-4, 1e-4, 1e-5, 1e-5, 1e-5, 1e-4, 1e-4};
constexpr size_t kPointsMin = 12;

// The gyro's turns between any two times.
class Gyro {
 public:
  Gyro(const std::vector<ImuSample>& imu, const ImuIntrinsics& intrinsics) : imu_(imu) {
    ImuCorrection correction;
    correction.configure(intrinsics);
    for (ImuSample& sample : imu_) correction.apply(sample);
    std::sort(imu_.begin(), imu_.end(),
              [](const ImuSample& a, const ImuSample& b) { return a.t < b.t; });
  }

  bool covers(double t0_s, double t1_s, TimeNs epoch) const {
    return !imu_.empty() && to_seconds(imu_.front().t - epoch) < t0_s &&
           to_seconds(imu_.back().t - epoch) > t1_s;
  }

  // R_B0B1.
  Mat3 turn(double t0_s, double t1_s, TimeNs epoch, const Vec3& bias) const {
    const TimeNs begin = epoch + from_seconds(t0_s);
    auto next = std::upper_bound(imu_.begin(), imu_.end(), begin,
                                 [](TimeNs t, const ImuSample& s) { return t < s.t; });
    Mat3 out = Mat3::Identity();
    double at_s = t0_s;
    Vec3 w = rate(next, at_s, epoch);
    while (at_s < t1_s && next != imu_.end()) {
      const double next_s = std::min(t1_s, to_seconds(next->t - epoch));
      const Vec3 w_next = rate(next, next_s, epoch);
      out = out * so3_exp((next_s - at_s) * ((w + w_next) / 2 - bias));
      at_s = next_s;
      w = w_next;
      ++next;
    }
    return out;
  }

 private:
  using Iterator = std::vector<ImuSample>::const_iterator;

  // Between the sample before `next` and `next`.
  Vec3 rate(Iterator next, double t_s, TimeNs epoch) const {
    if (next == imu_.begin()) return next->w_B;
    if (next == imu_.end()) return imu_.back().w_B;
    const ImuSample &a = *(next - 1), &b = *next;
    const double span_s = to_seconds(b.t - a.t);
    const double s = span_s > 0 ? (t_s - to_seconds(a.t - epoch)) / span_s : 1;
    return a.w_B + s * (b.w_B - a.w_B);
  }

  std::vector<ImuSample> imu_;
};

// What the unknowns make of one look.
struct Model {
  Camera left, right;
  Mat3 R_C1C0, R_later;
  Vec3 p_C1C0;
};

struct Point {
  Vec3 ray = Vec3::UnitZ();  // of the left image, z = 1 or a unit vector
  double inv_depth = 0;      // over the ray's length
  bool good = true;
};

struct Look {
  const FlightLook* seen = nullptr;
  double t0_s = 0, t1_s = 0;
  Vec3 p_later = Vec3::Zero();  // translation to the later camera
  std::vector<Point> points;
};

using Vec4 = Eigen::Matrix<double, 4, 1>;

class Judge {
 public:
  Judge(const std::vector<FlightLook>& looks, const std::vector<ImuSample>& imu,
        const Calibration& calibration)
      : calibration_(calibration), gyro_(imu, calibration.imu_intrinsics) {
    epoch_ = looks.front().t0 + calibration.camera_time_offset_ns;
    for (const FlightLook& look : looks) {
      Look in;
      in.seen = &look;
      in.t0_s = to_seconds(look.t0 + calibration.camera_time_offset_ns - epoch_);
      in.t1_s = to_seconds(look.t1 + calibration.camera_time_offset_ns - epoch_);
      constexpr double kSpare_s = 0.1;
      if (!gyro_.covers(in.t0_s - kSpare_s, in.t1_s + kSpare_s, epoch_)) continue;
      in.points.resize(look.points.size());
      looks_.push_back(in);
    }
    if (looks_.empty()) {
      throw InputError("images and IMU samples are not of one time", "the recording",
                       "check their stamps");
    }
    std::copy(kPriorSigma, kPriorSigma + kN, prior_.data());
  }

  FlightVerdict run() {
    constexpr int kRounds = 8;
    for (int round = 0; round < kRounds; ++round) {
      step();
      if (round < 3) sigma_px_ = std::max(0.05, robust_sigma());
    }
    return verdict();
  }

 private:
  Model model(const VecN& x, const Look& look) const {
    Model out;
    out.left = calibration_.camera[0];
    out.right = calibration_.camera[1];
    const double both = std::exp(x[kFocal]), other = std::exp(x[kFocal] + x[kOther]);
    out.left.fx *= both, out.left.fy *= both;
    out.right.fx *= other, out.right.fy *= other;
    const SE3 T_C0C1 = calibration_.camera[0].T_BC.inverse() * calibration_.camera[1].T_BC;
    const Mat3 R_C0C1 = so3_exp(x.segment<3>(kRight)) * T_C0C1.R;
    out.R_C1C0 = R_C0C1.transpose();
    out.p_C1C0 = -out.R_C1C0 * (T_C0C1.p + x.segment<3>(kPlace));
    const Mat3 R_BC = so3_exp(x.segment<3>(kTurn)) * calibration_.camera[0].T_BC.R;
    const Mat3 R_B0B1 =
        gyro_.turn(look.t0_s + x[kTime], look.t1_s + x[kTime], epoch_, x.segment<3>(kBias));
    out.R_later = R_BC.transpose() * R_B0B1.transpose() * R_BC;
    return out;
  }

  // Right and later image; false: not to be seen.
  static bool residual(const Model& m, const FlightPoint& seen, const Vec3& ray, double inv_depth,
                       const Vec3& p_later, Vec4& out) {
    Vec2 right, later;
    if (!m.right.project(m.R_C1C0 * ray + inv_depth * m.p_C1C0, right)) return false;
    if (!m.left.project(m.R_later * ray + inv_depth * p_later, later)) return false;
    out << right - seen.right, later - seen.later;
    return true;
  }

  // Huber's, of either image.
  void weigh(const Vec4& r, Vec2& weight) const {
    for (int i = 0; i < 2; ++i) {
      const double e = r.segment<2>(2 * i).norm() / (2 * sigma_px_);
      weight[i] = e > 1 ? 1 / e : 1;
    }
  }

  // Depths and translation as they fit the model best.
  void settle(const Model& m, Look& look) const {
    for (int round = 0; round < 4; ++round) {
      Mat3 H = Mat3::Identity() * 1e-9;
      Vec3 g = Vec3::Zero();
      for (size_t i = 0; i < look.points.size(); ++i) {
        Point& point = look.points[i];
        const FlightPoint& seen = look.seen->points[i];
        point.good = m.left.unproject(seen.left, point.ray);
        Vec4 r, J_depth;
        Eigen::Matrix<double, 4, 3> J;
        Vec2 weight;
        if (!point.good || !derivatives(m, seen, point, look.p_later, r, J_depth, J)) {
          point.good = false;
          continue;
        }
        weigh(r, weight);
        const Vec4 w(weight[0], weight[0], weight[1], weight[1]);
        const double h = J_depth.dot(w.cwiseProduct(J_depth)) + 1e-6;
        point.inv_depth -= std::clamp(J_depth.dot(w.cwiseProduct(r)) / h, -1.0, 1.0);
        if (!residual(m, seen, point.ray, point.inv_depth, look.p_later, r)) continue;
        H += weight[1] * J.bottomRows<2>().transpose() * J.bottomRows<2>();
        g += weight[1] * J.bottomRows<2>().transpose() * r.tail<2>();
      }
      look.p_later -= H.ldlt().solve(g);
    }
  }

  static bool derivatives(const Model& m, const FlightPoint& seen, const Point& point,
                          const Vec3& p_later, Vec4& r, Vec4& J_depth,
                          Eigen::Matrix<double, 4, 3>& J_later) {
    constexpr double kH = 1e-4;
    Vec4 a;
    if (!residual(m, seen, point.ray, point.inv_depth, p_later, r)) return false;
    if (!residual(m, seen, point.ray, point.inv_depth + kH, p_later, a)) return false;
    J_depth = (a - r) / kH;
    for (int k = 0; k < 3; ++k) {
      Vec3 p = p_later;
      p[k] += kH;
      if (!residual(m, seen, point.ray, point.inv_depth, p, a)) return false;
      J_later.col(k) = (a - r) / kH;
    }
    return true;
  }

  void step() {
    H_ = MatN::Zero();
    VecN g = VecN::Zero();
    for (int k = 0; k < kN; ++k) {
      H_(k, k) = 1 / (prior_[k] * prior_[k]);
      g[k] = x_[k] / (prior_[k] * prior_[k]);
    }
    errors_.clear();
    points_ = 0;
    for (Look& look : looks_) add(look, g);
    const VecN dx = H_.ldlt().solve(g);
    x_ -= dx;
  }

  void add(Look& look, VecN& g) {
    const Model m = model(x_, look);
    settle(m, look);
    Model turned[kN];
    for (int k = 0; k < kN; ++k) {
      VecN x = x_;
      x[k] += kStep[k];
      turned[k] = model(x, look);
    }
    constexpr int kAll = 3 + kN;
    Eigen::Matrix<double, kAll, kAll> A = Eigen::Matrix<double, kAll, kAll>::Zero();
    Eigen::Matrix<double, kAll, 1> b = Eigen::Matrix<double, kAll, 1>::Zero();
    for (size_t i = 0; i < look.points.size(); ++i) {
      const Point& point = look.points[i];
      const FlightPoint& seen = look.seen->points[i];
      Vec4 r, J_depth;
      Eigen::Matrix<double, 4, 3> J_later;
      Eigen::Matrix<double, 4, kAll> J;
      if (!point.good || !derivatives(m, seen, point, look.p_later, r, J_depth, J_later)) continue;
      J.leftCols<3>() = J_later;
      bool good = true;
      for (int k = 0; k < kN; ++k) {
        Vec3 ray;
        Vec4 a;
        good = good && turned[k].left.unproject(seen.left, ray) &&
               residual(turned[k], seen, ray, point.inv_depth, look.p_later, a);
        if (good) J.col(3 + k) = (a - r) / kStep[k];
      }
      constexpr double kWrong_px = 8;
      if (!good || r.cwiseAbs().maxCoeff() > kWrong_px) continue;
      Vec2 weight;
      weigh(r, weight);
      const Vec4 w = Vec4(weight[0], weight[0], weight[1], weight[1]) / (sigma_px_ * sigma_px_);
      const double h = J_depth.dot(w.cwiseProduct(J_depth)) + 1e-9;
      const Eigen::Matrix<double, kAll, 1> c = J.transpose() * w.cwiseProduct(J_depth);
      A += J.transpose() * w.asDiagonal() * J - c * c.transpose() / h;
      b += J.transpose() * w.cwiseProduct(r) - c * (J_depth.dot(w.cwiseProduct(r)) / h);
      errors_.push_back(r.head<2>().norm());
      errors_.push_back(r.tail<2>().norm());
      ++points_;
    }
    Mat3 H_later = A.topLeftCorner<3, 3>();
    H_later.diagonal().array() += 1e-3;
    const Eigen::Matrix<double, kN, 3> W = A.bottomLeftCorner<kN, 3>();
    const auto factor = H_later.ldlt();
    H_ += A.bottomRightCorner<kN, kN>() - W * factor.solve(W.transpose());
    g += b.tail<kN>() - W * factor.solve(b.head<3>());
  }

  // Of a pixel's coordinate: the median length of two of them is 1.18 sigma.
  double robust_sigma() {
    if (errors_.size() < 2 * kPointsMin) {
      throw InputError("hardly any points are seen by both cameras and again", "the recording",
                       "give one with texture in view, in focus");
    }
    const auto middle = errors_.begin() + long(errors_.size() / 2);
    std::nth_element(errors_.begin(), middle, errors_.end());
    return *middle / 1.18;
  }

  FlightVerdict verdict() {
    FlightVerdict out;
    out.looks = looks_.size();
    out.points = points_;
    out.residual_px = robust_sigma();
    // Errors of one scene come together: no flight of a thousand looks is a thousand flights.
    constexpr double kOptimism = 5;
    const MatN P = H_.inverse();
    const auto add = [&](const std::string& what, const char* unit, int k, double scale,
                         double limit) {
      out.findings.push_back(
          {what, unit, scale * x_[k], kOptimism * scale * std::sqrt(P(k, k)), limit});
    };
    constexpr double kDegrees = 180 / M_PI;
    add("time offset of the cameras", "ms", kTime, 1e3, 2.5);
    const char* const axes[3] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      add(std::string("cameras against the IMU, about B's ") + axes[i], "degrees", kTurn + i,
          kDegrees, 0.2);
    }
    for (int i = 0; i < 3; ++i) {
      add(std::string("right camera against left, about C0's ") + axes[i], "degrees", kRight + i,
          kDegrees, 0.2);
    }
    add("focal length of both cameras", "%", kFocal, 100, 0.5);
    add("focal length of the right one", "%", kOther, 100, 0.5);
    return out;
  }

  const Calibration& calibration_;
  Gyro gyro_;
  TimeNs epoch_ = 0;
  std::vector<Look> looks_;
  VecN x_ = VecN::Zero(), prior_;
  MatN H_ = MatN::Identity();
  double sigma_px_ = 1;
  std::vector<double> errors_;
  size_t points_ = 0;
};

}  // namespace

bool FlightFinding::bumped() const {
  return std::abs(value) > limit && std::abs(value) > 3 * sigma;
}

bool FlightVerdict::bumped() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const FlightFinding& finding) { return finding.bumped(); });
}

FlightVerdict judge(const std::vector<FlightLook>& looks, const std::vector<ImuSample>& imu,
                    const Calibration& calibration) {
  if (looks.empty()) {
    throw InputError("hardly any points are seen by both cameras and again", "the recording",
                     "give one with texture in view, in focus");
  }
  return Judge(looks, imu, calibration).run();
}

}  // namespace pirvs::tools
