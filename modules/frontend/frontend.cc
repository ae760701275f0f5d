#include "modules/frontend/frontend.h"

#include <algorithm>
#include <cmath>

#include "core/base/assert.h"
#include "core/kernels/corner/corner.h"
#include "core/kernels/lk/lk.h"

namespace pirvs {
namespace {

constexpr float kDetectMargin_px = 20.0f;     // what describe() reads around a point
constexpr float kResidualAlways_grey = 4.0f;  // that a good track may have in the sharpest image
constexpr float kFollowMargin_px = 10.0f;     // half a flow patch, its gradients and interpolation

bool inside(const ImageView& image, float x, float y, float margin) {
  return x >= margin && y >= margin && x <= static_cast<float>(image.width - 1) - margin &&
         y <= static_cast<float>(image.height - 1) - margin;
}

float squared_distance(const Track& track, float x, float y) {
  const float dx = track.x - x, dy = track.y - y;
  return dx * dx + dy * dy;
}

}  // namespace

const char* name(TrackLoss loss) {
  static constexpr const char* kNames[] = {"track_left_image", "track_flow", "track_residual",
                                           "track_return", "track_spacing"};
  static_assert(std::size(kNames) == static_cast<size_t>(TrackLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

DetectionGrid detection_grid(int width, int height, int side_px) {
  constexpr int kMargin = static_cast<int>(kDetectMargin_px);
  static_assert(kImagePixelsMax / (kCornerSizeMax * kCornerSizeMax) <= kDetectionCellsMax,
                "cells of the size that corner_best takes cover the largest image");
  const int room_x = width - 2 * kMargin, room_y = height - 2 * kMargin;
  if (room_x <= 0 || room_y <= 0) return {side_px, 0, 0};
  int side = std::min({side_px, room_x, room_y});
  while ((room_x / side) * (room_y / side) > kDetectionCellsMax) ++side;
  return {side, room_x / side, room_y / side};
}

void Frontend::configure(const Camera& camera, const FrontendParams& params) {
  camera_ = camera;
  retune(params);
  reset();
}

void Frontend::retune(const FrontendParams& params) {
  params_ = params;
  grid_ = detection_grid(camera_.width, camera_.height, static_cast<int>(params.bin_px));
  std::fill(std::begin(bin_wait_), std::end(bin_wait_), uint8_t{0});
}

void Frontend::reset() {
  has_image_ = false;
  tracks_.clear();
  free_slots_.clear();
  for (int slot = kTracksMax; slot-- > 0;) (void)free_slots_.push_back(static_cast<uint16_t>(slot));
  for (uint8_t& wait : bin_wait_) wait = 0;
}

void Frontend::predict(const Mat3& R_C1C0) {
  for (Track& track : tracks_) {
    track.x_pred = track.x;
    track.y_pred = track.y;
    Vec3 bearing_C0;
    Vec2 uv;
    if (!camera_.unproject(Vec2(track.x, track.y), bearing_C0)) continue;
    if (!camera_.project(R_C1C0 * bearing_C0, uv)) continue;
    track.x_pred = static_cast<float>(uv.x());
    track.y_pred = static_cast<float>(uv.y());
  }
}

Status Frontend::process(const ImageView& image, TimeNs t, const Vec3& gravity_C) {
  if (image.width != camera_.width || image.height != camera_.height) return Status::kBadData;
  if (has_image_ && t <= t_) return Status::kBadData;
  current_ ^= 1;
  pyramid_[current_].build(image, static_cast<int>(params_.lk_levels));
  if (has_image_) follow();
  space_out();
  detect(gravity_C);
  has_image_ = true;
  t_ = t;
  return Status::kOk;
}

void Frontend::follow() {
  FixedVector<float, kTracksMax> residuals;  // of the tracks that are kept
  size_t kept = 0;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    TrackLoss why = TrackLoss::kFlow;
    float residual = 0;
    if (follow_one(tracks_[i], residual, why)) {
      tracks_[kept++] = tracks_[i];
      (void)residuals.push_back(residual);
    } else {
      release(tracks_[i]);
      losses_.add(why);
    }
  }
  tracks_.resize(kept);
  drop_misfits(residuals);
}

// What most tracks leave over is noise, light and blur; a patch that leaves over much more has
// something else in it: the edge of a near object, which slides over what is behind.
void Frontend::drop_misfits(const FixedVector<float, kTracksMax>& residuals) {
  if (residuals.empty()) return;
  FixedVector<float, kTracksMax> sorted = residuals;
  float* const middle = sorted.begin() + sorted.size() / 2;
  std::nth_element(sorted.begin(), middle, sorted.end());
  const float limit = std::max(kResidualAlways_grey, params_.lk_residual_ratio_max * *middle);
  for (size_t i = tracks_.size(); i-- > 0;) {
    if (residuals[i] <= limit) continue;
    erase(i);  // the last one takes its place, and has been judged
    losses_.add(TrackLoss::kResidual);
  }
}

void Frontend::release(const Track& track) {
  const bool released = free_slots_.push_back(track.slot);
  PIRVS_ASSERT(released);  // as many slots as there can be tracks
}

void Frontend::erase(size_t i) {
  release(tracks_[i]);
  tracks_.erase_unordered(i);
}

bool Frontend::follow_one(Track& track, float& residual, TrackLoss& why) {
  const PyramidStore& from = pyramid_[current_ ^ 1];
  const PyramidStore& to = pyramid_[current_];
  const int iterations = static_cast<int>(params_.lk_iterations_max);
  float x = track.x_pred, y = track.y_pred;
  why = TrackLoss::kLeftImage;
  if (!inside(to.level(0), x, y, 0)) return false;
  LkPatch patch;
  for (int l = to.levels() - 1; l >= 0; --l) {
    const float scale = 1.0f / static_cast<float>(1 << l);
    // A coarse patch that leaves the image says nothing; only the finest must succeed.
    if (!lk_extract(from.level(l), track.x * scale, track.y * scale, patch) || !patch.usable) {
      if (l == 0) return false;
      continue;
    }
    float xl = x * scale, yl = y * scale;
    const float step = l == 0 ? params_.lk_step_px_min : 2 * params_.lk_step_px_min;
    if (lk_align(to.level(l), patch, xl, yl, iterations, step, residual)) {
      x = xl / scale;
      y = yl / scale;
    } else if (l == 0) {
      why = TrackLoss::kFlow;
      return false;
    }
  }
  if (!inside(to.level(0), x, y, kFollowMargin_px)) return false;
  why = TrackLoss::kResidual;
  if (residual > params_.lk_residual_grey_max) return false;

  why = TrackLoss::kReturn;
  float back_x = track.x, back_y = track.y, back_residual = 0;
  if (!lk_extract(to.level(0), x, y, patch) || !patch.usable) return false;
  if (!lk_align(from.level(0), patch, back_x, back_y, 3, params_.lk_step_px_min, back_residual)) {
    return false;
  }
  if (squared_distance(track, back_x, back_y) >
      params_.lk_return_px_max * params_.lk_return_px_max) {
    return false;
  }
  track.x_last = track.x;
  track.y_last = track.y;
  track.x = x;
  track.y = y;
  if (track.age < UINT16_MAX) ++track.age;
  return true;
}

// Of two tracks that have run together the older one stays.
void Frontend::space_out() {
  const float spacing = 0.5f * params_.track_spacing_px_min;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    for (size_t j = i + 1; j < tracks_.size();) {
      if (squared_distance(tracks_[j], tracks_[i].x, tracks_[i].y) >= spacing * spacing) {
        ++j;
        continue;
      }
      if (tracks_[j].age > tracks_[i].age) std::swap(tracks_[i], tracks_[j]);
      erase(j);
      losses_.add(TrackLoss::kSpacing);
    }
  }
}

void Frontend::detect(const Vec3& gravity_C) {
  const size_t target = static_cast<size_t>(params_.tracks_target);
  if (tracks_.size() >= target) return;
  const ImageView& image = pyramid_[current_].level(0);
  const int bin = grid_.side_px, columns = grid_.columns, rows = grid_.rows;
  const int margin = static_cast<int>(kDetectMargin_px);
  bool taken[kDetectionCellsMax] = {};
  for (const Track& track : tracks_) {
    const int column = (static_cast<int>(track.x) - margin) / bin;
    const int row = (static_cast<int>(track.y) - margin) / bin;
    if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
    taken[row * columns + column] = true;
  }
  FixedVector<Corner, kDetectionCellsMax> found;
  for (int b = 0; b < columns * rows; ++b) {
    if (taken[b]) continue;
    if (bin_wait_[b] > 0) {
      --bin_wait_[b];
      continue;
    }
    Corner corner;
    if (corner_best(image, margin + b % columns * bin, margin + b / columns * bin, bin, bin,
                    params_.corner_response_min, corner)) {
      (void)found.push_back(corner);  // one a bin: never full
    } else {
      bin_wait_[b] = static_cast<uint8_t>(params_.bin_wait_frames);
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Corner& a, const Corner& b) { return a.response > b.response; });
  for (const Corner& corner : found) {
    if (tracks_.size() >= target) break;
    const float x = corner.x, y = corner.y;
    if (nearest(x, y, params_.track_spacing_px_min) != nullptr) continue;
    if (start_track(x, y, nullptr) == 0) continue;
    describe_track(tracks_.back(), gravity_C);
  }
}

void Frontend::describe_track(Track& track, const Vec3& gravity_C) const {
  Vec3 bearing;
  Vec2 uv;
  Mat23 J;
  float cos_a = 1, sin_a = 0;
  if (camera_.unproject(Vec2(track.x, track.y), bearing) && camera_.project(bearing, uv, J)) {
    const Vec2 down = J * gravity_C;
    const double norm = down.norm();
    if (norm > 1e-9) {
      // Angle 0: gravity points down the image, the way a level camera sees it.
      cos_a = static_cast<float>(down.y() / norm);
      sin_a = static_cast<float>(-down.x() / norm);
    }
  }
  describe(pyramid_[current_].level(0), track.x, track.y, cos_a, sin_a, track.descriptor);
  track.described = true;
}

TrackId Frontend::start_track(float x, float y, const Descriptor* descriptor) {
  if (!inside(pyramid_[current_].level(0), x, y, kFollowMargin_px)) return 0;
  Track* track = tracks_.append();
  if (track == nullptr) return 0;
  *track = Track{};
  track->id = next_id_++;
  track->slot = free_slots_.back();
  free_slots_.pop_back();
  track->x = track->x_pred = x;
  track->y = track->y_pred = y;
  if (descriptor != nullptr) {
    track->descriptor = *descriptor;
    track->described = true;
  }
  return track->id;
}

Track* Frontend::nearest(float x, float y, float radius_px) {
  Track* best = nullptr;
  float best_d2 = radius_px * radius_px;
  for (Track& track : tracks_) {
    const float d2 = squared_distance(track, x, y);
    if (d2 >= best_d2) continue;
    best_d2 = d2;
    best = &track;
  }
  return best;
}

}  // namespace pirvs
