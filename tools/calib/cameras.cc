#include "tools/calib/cameras.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/math/so3.h"
#include "tools/calib/board_pose.h"
#include "tools/calib/coverage.h"
#include "tools/calib/shot_choice.h"
#include "tools/calib/tag_image.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr size_t kViewsMin = 15;
constexpr size_t kTagsMin = 6;       // of a view, to be worth a look
constexpr double kGoodPose_px = 30;  // with a lens that is a guess
constexpr double kStart_px = 10;     // no lens at all explains the views

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return HUGE_VAL;
  const auto at = values.begin() + long(q * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// One camera's shots as if it were the left one.
std::vector<Shot> alone(const std::vector<Shot>& shots, int camera) {
  std::vector<Shot> out;
  for (const Shot& shot : shots) {
    if (shot.view[camera].tags.size() >= kTagsMin) {
      out.push_back({shot.t, {shot.view[camera], View{}}});
    }
  }
  return out;
}

// Of each of `parts` equal stretches of the recording the shot with most tags.
std::vector<Shot> spread(const std::vector<Shot>& shots, size_t parts) {
  std::vector<Shot> out;
  for (size_t part = 0; part < std::min(parts, shots.size()); ++part) {
    const auto begin = shots.begin() + long(part * shots.size() / parts);
    const auto end = shots.begin() + long((part + 1) * shots.size() / parts);
    if (begin == end) continue;
    out.push_back(*std::max_element(begin, end, [](const Shot& a, const Shot& b) {
      return a.view[0].tags.size() < b.view[0].tags.size();
    }));
  }
  return out;
}

Camera plain_camera(CameraModel model, ImageSize size, double focal_px) {
  Camera out;
  out.model = model;
  out.width = size.width;
  out.height = size.height;
  out.fx = out.fy = focal_px;
  out.cx = (size.width - 1) / 2.0;
  out.cy = (size.height - 1) / 2.0;
  return out;
}

// The focal length without distortion that explains views best.
Camera start_camera(const Target& target, CameraModel model, ImageSize size,
                    const std::vector<Shot>& views) {
  Camera best;
  double best_px = HUGE_VAL;
  for (double share = 0.2; share < 3; share *= 1.15) {
    const Camera camera = plain_camera(model, size, share * size.width);
    std::vector<double> errors;
    for (const Shot& shot : views) {
      BoardPose pose;
      const bool found = find_pose(camera, target, shot.view[0], pose);
      errors.push_back(found ? pose.rms_px : HUGE_VAL);
    }
    const double px = quantile(errors, 0.6);
    if (px < best_px) best = camera, best_px = px;
  }
  return best;
}

Camera calibrate_alone(const Target& target, CameraModel model, ImageSize size,
                       const std::vector<Shot>& shots) {
  constexpr size_t kFirst = 12, kSecond = 40;
  CameraRig rig;
  rig.camera[0] = start_camera(target, model, size, spread(shots, kFirst));
  Adjustment adjustment;
  for (const size_t parts : {kFirst, kSecond}) {
    std::vector<PosedShot> posed = pose_shots(target, rig, spread(shots, parts));
    Target flat = target;
    if (posed.size() < kFirst / 2 || !adjust(flat, false, rig, posed, adjustment)) {
      adjustment.sigma_px = HUGE_VAL;
      break;
    }
  }
  if (adjustment.sigma_px > kStart_px) {
    throw InputError("no lens explains these views of the board",
                     model == CameraModel::kPinholeRadtan ? "radtan" : "equidistant",
                     "check the target's yaml (rows, columns, spacing) and --size");
  }
  return rig.camera[0];
}

// Of the shots that both cameras saw, the transform that agrees best with all others.
SE3 start_stereo(const Target& target, const CameraRig& rig, const std::vector<Shot>& shots) {
  std::vector<SE3> found;
  for (const Shot& shot : shots) {
    BoardPose pose[2];
    bool both = true;
    for (int c = 0; c < 2; ++c) {
      both = both && find_pose(rig.camera[c], target, shot.view[c], pose[c]) && pose[c].rms_px < 2;
    }
    if (both) found.push_back(pose[1].T_CT * pose[0].T_CT.inverse());
  }
  if (found.size() < kViewsMin) {
    throw InputError("the cameras see the board together in too few shots",
                     std::to_string(found.size()), "keep the board in both views");
  }
  SE3 best;
  double least = HUGE_VAL;
  const double size = target.diagonal_m();
  for (size_t i = 0; i < found.size(); i += 1 + found.size() / 100) {
    std::vector<double> off;
    for (const SE3& other : found) {
      off.push_back(so3_log(found[i].R.transpose() * other.R).norm() +
                    (found[i].p - other.p).norm() / size);
    }
    const double middle = quantile(off, 0.5);
    if (middle < least) least = middle, best = found[i];
  }
  return best;
}

// Root mean square of errors of one view at a pose; gross errors are left to the detector.
double error_px(const Camera& camera, const Target& target, const View& view,
                const BoardPose& pose) {
  constexpr double kGross_px = 5;
  double squares = 0;
  size_t count = 0;
  for (const SeenTag& tag : view.tags) {
    TagImage image;
    if (!project_tag(camera, target, pose.T_CT, tag.id, image)) continue;
    const double e = (image.uv - tag.uv).norm();
    if (e > kGross_px) continue;
    squares += e * e;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / double(2 * count)) : HUGE_VAL;
}

// A blurred image is not outvoted by sharp ones: its tags are off as one. What stays is the sharper
// half, by how well one pose explains each image.
std::vector<PosedShot> sharper_half(const Target& target, const CameraRig& rig,
                                    const std::vector<PosedShot>& shots) {
  std::vector<double> errors;
  for (const PosedShot& shot : shots) {
    double worst = 0;
    for (int c = 0; c < rig.cameras; ++c) {
      BoardPose pose{c == 0 ? shot.T_C0T : rig.T_C1C0 * shot.T_C0T, 0};
      if (!refine_pose(rig.camera[c], target, shot.shot.view[c], pose)) continue;
      worst = std::max(worst, pose.rms_px);
    }
    errors.push_back(worst);
  }
  const double middle = quantile(errors, 0.5);
  std::vector<PosedShot> out;
  for (size_t i = 0; i < shots.size(); ++i) {
    if (errors[i] <= middle) out.push_back(shots[i]);
  }
  return out;
}

HeldOut hold_out(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& all,
                 const std::vector<PosedShot>& used) {
  constexpr size_t kMost = 300;
  std::vector<double> within[2], across;
  HeldOut out;
  for (size_t i = 0; i < all.size(); i += 1 + all.size() / kMost) {
    const auto at =
        std::lower_bound(used.begin(), used.end(), all[i].shot.t,
                         [](const PosedShot& shot, TimeNs t) { return shot.shot.t < t; });
    if (at != used.end() && at->shot.t == all[i].shot.t) continue;
    ++out.shots;
    for (int c = 0; c < rig.cameras; ++c) {
      const View& view = all[i].shot.view[c];
      BoardPose pose;
      if (!find_pose(rig.camera[c], target, view, pose)) continue;
      within[c].push_back(error_px(rig.camera[c], target, view, pose));
      if (c == 1 || rig.cameras == 1) continue;
      pose.T_CT = rig.T_C1C0 * pose.T_CT;
      const double e = error_px(rig.camera[1], target, all[i].shot.view[1], pose);
      if (std::isfinite(e)) across.push_back(e);
    }
  }
  for (int c = 0; c < rig.cameras; ++c) {
    out.within_px[c] = within[c].empty() ? 0 : quantile(within[c], 0.5);
  }
  out.across_px = across.empty() ? 0 : quantile(across, 0.5);
  return out;
}

void refuse_what_is_missing(CameraResult& out) {
  out.coverage = measure(out.target, out.rig, out.all);
  const Lack lack = missing(out.coverage, out.rig.cameras);
  if (lack.what.empty()) return;
  for (int c = 0; c < out.rig.cameras; ++c) {
    std::fprintf(stderr, "tags seen by cam%d:\n%s", c, picture(out.coverage, c).c_str());
  }
  throw InputError(lack.what, "the recording", lack.remedy);
}

CameraResult calibrate_model(const Target& target, const std::vector<Shot>& shots, int cameras,
                             CameraModel model, ImageSize size) {
  CameraResult out;
  out.target = target;
  out.rig.cameras = cameras;
  for (int c = 0; c < cameras; ++c) {
    const std::vector<Shot> views = alone(shots, c);
    if (views.size() < kViewsMin) {
      throw InputError("the board is seen in too few images",
                       "cam" + std::to_string(c) + ", " + std::to_string(views.size()),
                       "record it for a minute, from near and far, tilted, all over the image; "
                       "blurred images show no tags: more light, shorter exposure");
    }
    out.rig.camera[c] = calibrate_alone(target, model, size, views);
  }
  if (cameras == 2) out.rig.T_C1C0 = start_stereo(target, out.rig, shots);
  for (int round = 0; round < 2; ++round) {  // the second time with a rig that is nearly right
    out.all = pose_shots(out.target, out.rig, shots);
    refuse_what_is_missing(out);
    const std::vector<PosedShot> sharp = sharper_half(out.target, out.rig, out.all);
    const std::vector<size_t> chosen = choose_shots(out.target, out.rig, sharp, {});
    out.used.clear();
    for (const size_t i : chosen) out.used.push_back(sharp[i]);
    if (!adjust(out.target, true, out.rig, out.used, out.adjustment)) {
      throw InputError("the views leave the lens open", std::to_string(chosen.size()) + " shots",
                       "record the board tilted, from near and far, all over the image");
    }
  }
  out.all = pose_shots(out.target, out.rig, shots);
  out.held_out = hold_out(out.target, out.rig, out.all, out.used);
  return out;
}

}  // namespace

std::vector<PosedShot> pose_shots(const Target& target, const CameraRig& rig,
                                  const std::vector<Shot>& shots) {
  std::vector<PosedShot> out;
  for (const Shot& shot : shots) {
    const bool second = rig.cameras == 2 && shot.view[1].tags.size() > shot.view[0].tags.size();
    const int c = second ? 1 : 0;
    if (shot.view[c].tags.size() < kTagsMin) continue;
    BoardPose pose;
    if (!find_pose(rig.camera[c], target, shot.view[c], pose)) continue;
    if (pose.rms_px > kGoodPose_px) continue;
    out.push_back({shot, c == 0 ? pose.T_CT : rig.T_C1C0.inverse() * pose.T_CT});
  }
  return out;
}

CameraResult calibrate_cameras(const Target& target, const std::vector<Shot>& shots, int cameras,
                               const CameraOptions& options) {
  if (options.model) {
    return calibrate_model(target, shots, cameras, *options.model, options.size);
  }
  constexpr CameraModel kModels[2] = {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt};
  std::optional<CameraResult> result[2];
  std::string why;
  for (int i = 0; i < 2; ++i) {
    try {
      result[i] = calibrate_model(target, shots, cameras, kModels[i], options.size);
    } catch (const InputError& error) {  // a lens that this model cannot describe
      if (result[0] || i == 0) continue;
      throw;
    }
  }
  const auto error = [](const std::optional<CameraResult>& r) {
    return r ? r->held_out.within_px[0] + r->held_out.within_px[1] : HUGE_VAL;
  };
  const int best = error(result[1]) < error(result[0]) ? 1 : 0;
  CameraResult out = std::move(*result[best]);
  if (result[1 - best]) out.other_model_px = result[1 - best]->held_out.within_px[0];
  return out;
}

}  // namespace pirvs::tools
