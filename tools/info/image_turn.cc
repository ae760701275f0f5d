#include "tools/info/image_turn.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/math/so3.h"
#include "tools/dataset/gyro_integral.h"
#include "tools/dataset/left_images.h"
#include "tools/dataset/player.h"

namespace pirvs::tools {
namespace {

constexpr double kDegree = M_PI / 180;

struct Pair {
  TimeNs begin = 0, end = 0;
  Vec3 w_C = Vec3::Zero();
};

// Frames that follow each other and between which the body turns most.
std::vector<size_t> choose(const Recording& recording, const GyroIntegral& gyro) {
  constexpr size_t kPairsMax = 120;
  const TimeNs offset = recording.calibration.camera_time_offset_ns;
  std::vector<std::pair<double, size_t>> all;
  for (size_t i = 1; i < recording.frames.size(); ++i) {
    const FrameFiles &a = recording.frames[i - 1], &b = recording.frames[i];
    const auto has = [](const FrameFiles& f) {
      return !f.image[0].empty() || f.pixels[0].data != nullptr;
    };
    Vec3 w_B;
    if (!has(a) || !has(b) || !gyro.rate(a.t + offset, b.t + offset, w_B)) continue;
    all.emplace_back(w_B.norm(), i);
  }
  std::sort(all.rbegin(), all.rend());
  // Not the fastest alone: every second of the faster half.
  std::vector<size_t> out;
  const size_t half = std::max(std::min(all.size(), kPairsMax), all.size() / 2);
  const size_t stride = std::max<size_t>(1, half / kPairsMax);
  for (size_t i = 0; i < half && out.size() < kPairsMax; i += stride) out.push_back(all[i].second);
  std::sort(out.begin(), out.end());
  return out;
}

cv::Mat mat_of(const ImageView& image) {
  cv::Mat out(image.height, image.width, CV_8UC1);
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, out.ptr(y));
  return out;
}

bool seen(const Camera& camera, const cv::Point2f& uv, cv::Point2d& out) {
  constexpr double kFront = 0.3;  // of a bearing's z: wider rays make a poor plane
  Vec3 bearing_C;
  if (!camera.unproject(Vec2(uv.x, uv.y), bearing_C) || bearing_C.z() < kFront) return false;
  out = {bearing_C.x() / bearing_C.z(), bearing_C.y() / bearing_C.z()};
  return true;
}

bool turn_between(const Camera& camera, const cv::Mat& before, const cv::Mat& after, double dt_s,
                  Vec3& w_C) {
  constexpr int kCorners = 250, kInliersMin = 25;
  std::vector<cv::Point2f> from, to;
  cv::goodFeaturesToTrack(before, from, kCorners, 0.01, 12);
  if (int(from.size()) < kInliersMin) return false;
  std::vector<uint8_t> found;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(before, after, from, to, found, error, cv::Size(21, 21), 4);
  std::vector<cv::Point2d> a, b;
  for (size_t i = 0; i < from.size(); ++i) {
    cv::Point2d p, q;
    if (!found[i] || !seen(camera, from[i], p) || !seen(camera, to[i], q)) continue;
    a.push_back(p);
    b.push_back(q);
  }
  if (int(a.size()) < kInliersMin) return false;
  cv::setRNGSeed(1);
  cv::Mat mask, R, t;
  const cv::Mat E =
      cv::findEssentialMat(a, b, 1.0, cv::Point2d(0, 0), cv::RANSAC, 0.99, 1.0 / camera.fx, mask);
  if (E.rows != 3 || E.cols != 3) return false;
  if (cv::recoverPose(E, a, b, R, t, 1.0, cv::Point2d(0, 0), mask) < kInliersMin) return false;
  Mat3 R_after_before;
  for (int i = 0; i < 9; ++i) R_after_before(i / 3, i % 3) = R.at<double>(i / 3, i % 3);
  w_C = -so3_log(R_after_before) / dt_s;
  return w_C.allFinite();
}

std::vector<Pair> measure(const Recording& recording, const std::vector<size_t>& chosen) {
  Recording part = left_images(recording);
  for (const size_t i : chosen) {
    part.frames.push_back(recording.frames[i - 1]);
    part.frames.push_back(recording.frames[i]);
  }
  std::vector<Pair> out;
  if (part.frames.empty()) return out;
  Player player(part);
  cv::Mat before;
  TimeNs begin = 0;
  for (size_t n = 0; const StereoFrame* const frame = player.next(); ++n) {
    const cv::Mat image = (frame->present & 1) != 0 ? mat_of(frame->image[0]) : cv::Mat();
    Pair pair = {begin, frame->t, Vec3::Zero()};
    const bool whole = n % 2 == 1 && !before.empty() && !image.empty();
    if (whole && turn_between(recording.calibration.camera[0], before, image,
                              to_seconds(frame->t - begin), pair.w_C)) {
      out.push_back(pair);
    }
    before = image;
    begin = frame->t;
    player.release(frame);
  }
  return out;
}

struct Fit {
  Mat3 R_BC = Mat3::Identity();
  double scale = 1;
  double misfit = 1;  // of what the gyro measured, the share that the images do not show
  size_t pairs = 0;
};

// w_B = scale R_BC w_C + bias, robustly.
Fit fit_rates(const std::vector<Vec3>& w_B, const std::vector<Vec3>& w_C) {
  constexpr int kRounds = 4;
  Fit out;
  out.pairs = w_B.size();
  std::vector<double> weight(w_B.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    Vec3 mean_B = Vec3::Zero(), mean_C = Vec3::Zero();
    double sum = 0;
    for (size_t i = 0; i < w_B.size(); ++i) {
      mean_B += weight[i] * w_B[i];
      mean_C += weight[i] * w_C[i];
      sum += weight[i];
    }
    mean_B /= sum;
    mean_C /= sum;
    Mat3 H = Mat3::Zero();
    double of_C = 0, of_B = 0;
    for (size_t i = 0; i < w_B.size(); ++i) {
      H += weight[i] * (w_B[i] - mean_B) * (w_C[i] - mean_C).transpose();
      of_C += weight[i] * (w_C[i] - mean_C).squaredNorm();
      of_B += weight[i] * (w_B[i] - mean_B).squaredNorm();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 &U = svd.matrixU(), &V = svd.matrixV();
    const double sign = (U * V.transpose()).determinant() < 0 ? -1 : 1;
    out.R_BC = U * Vec3(1, 1, sign).asDiagonal() * V.transpose();
    out.scale = of_C > 0 ? (svd.singularValues().dot(Vec3(1, 1, sign))) / of_C : 0;
    double left = 0;
    std::vector<double> errors;
    for (size_t i = 0; i < w_B.size(); ++i) {
      const Vec3 e = w_B[i] - mean_B - out.scale * out.R_BC * (w_C[i] - mean_C);
      left += weight[i] * e.squaredNorm();
      errors.push_back(e.norm());
    }
    out.misfit = of_B > 0 ? left / of_B : 1;
    std::vector<double> sorted = errors;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2),
                     sorted.end());
    const double middle = std::max(1e-4, sorted[sorted.size() / 2]);
    for (size_t i = 0; i < errors.size(); ++i) {
      const double r = errors[i] / (2 * middle);
      weight[i] = 1 / (1 + r * r);
    }
  }
  return out;
}

Fit fit_at(const std::vector<Pair>& pairs, const GyroIntegral& gyro, TimeNs offset) {
  std::vector<Vec3> w_B, w_C;
  for (const Pair& pair : pairs) {
    Vec3 w;
    if (!gyro.rate(pair.begin + offset, pair.end + offset, w)) continue;
    w_B.push_back(w);
    w_C.push_back(pair.w_C);
  }
  constexpr size_t kPairsMin = 15;
  return w_B.size() < kPairsMin ? Fit{} : fit_rates(w_B, w_C);
}

std::string text(const char* format, double value) {
  char out[240];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

}  // namespace

ImageTurn compare_turns(const Recording& recording) {
  constexpr TimeNs kLag_max = 160'000'000, kStep = 4'000'000;
  constexpr double kMisfit_max = 0.35;
  ImageTurn out;
  if (recording.imu.size() < 2 || recording.frames.size() < 2) return out;
  const GyroIntegral gyro(recording.imu);
  const std::vector<Pair> pairs = measure(recording, choose(recording, gyro));
  const TimeNs offset = recording.calibration.camera_time_offset_ns;
  Fit best;
  size_t best_at = 0;
  for (TimeNs lag = -kLag_max; lag <= kLag_max; lag += kStep) {
    const Fit fit = fit_at(pairs, gyro, offset + lag);
    if (fit.misfit < best.misfit) {
      best = fit;
      best_at = out.misfit.size();
    }
    out.lag_s.push_back(to_seconds(lag));
    out.misfit.push_back(fit.misfit);
    if (lag == 0) out.as_given = 1 - fit.misfit;
  }
  out.pairs = best.pairs;
  out.agreement = 1 - best.misfit;
  const bool inside = best_at > 0 && best_at + 1 < out.misfit.size();
  out.enough = best.misfit < kMisfit_max && inside;
  if (!out.enough) return out;
  // The vertex of the parabola through the best lag and its neighbours.
  const double a = out.misfit[best_at - 1], b = out.misfit[best_at], c = out.misfit[best_at + 1];
  const double shift = a - 2 * b + c > 0 ? 0.5 * (a - c) / (a - 2 * b + c) : 0;
  out.late_s = -(out.lag_s[best_at] + shift * to_seconds(kStep));
  const Mat3& R_BC = recording.calibration.camera[0].T_BC.R;
  out.off_deg = so3_log(R_BC.transpose() * best.R_BC).norm() / kDegree;
  out.inverse_off_deg = so3_log(R_BC * best.R_BC).norm() / kDegree;
  out.gyro_scale = best.scale;
  return out;
}

std::vector<std::string> faults_of(const ImageTurn& turn) {
  constexpr double kOff_deg = 12, kLate_s = 0.006, kScale = 0.15;
  // A lag is the stamps' where nothing else is left over, or where without it twice as much is: by
  // chance that happens to 15 pairs once in a hundred times (F-test of 45 against 45).
  constexpr double kAgreement = 0.97, kTimes = 2;
  std::vector<std::string> out;
  if (!turn.enough) return out;
  if (turn.off_deg > kOff_deg && turn.inverse_off_deg < kOff_deg) {
    out.push_back(
        "the images turn as the inverse of the calibration's rotation says: invert T_BS, which "
        "takes camera to body coordinates");
  } else if (turn.off_deg > kOff_deg) {
    out.push_back(
        text("by the turn of its images the left camera stands %.0f degrees other than "
             "the calibration says: check T_BS, and which camera is which",
             turn.off_deg));
  }
  const bool clear =
      turn.agreement > kAgreement || 1 - turn.as_given > kTimes * (1 - turn.agreement);
  if (clear && std::abs(turn.late_s) > kLate_s) {
    out.push_back(text("the left camera's stamps seem %.0f ms ", 1e3 * std::abs(turn.late_s)) +
                  (turn.late_s > 0 ? "late" : "early") +
                  text(": --set-offset %.3f, or --estimate time", turn.late_s));
  }
  if (std::abs(std::log(std::max(turn.gyro_scale, 1e-3))) > kScale) {
    out.push_back(
        text("the gyro turns %.3g times as far as the images: check its unit, and the "
             "calibration's focal lengths and lens model",
             turn.gyro_scale));
  }
  return out;
}

}  // namespace pirvs::tools
