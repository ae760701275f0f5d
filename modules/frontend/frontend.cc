#include "modules/frontend/frontend.h"

#include <algorithm>
#include <cmath>

#include "core/base/assert.h"
#include "core/kernels/corner/corner.h"
#include "core/kernels/lk/lk.h"

namespace pirvs {
namespace {

constexpr float kDetectMargin_px = 20.0f;  // what describe() reads around a point
constexpr size_t kSearchesPerTrack = 4;
constexpr int kBinStride = 613;               // prime, so that all bins are visited
constexpr float kResidualAlways_grey = 4.0f;  // that a good track may have in the sharpest image
constexpr float kLookResidualAlways_grey = 6.0f;  // the same against its first look
constexpr float kFollowMargin_px = 10.0f;  // half a flow patch, its gradients and interpolation
constexpr float kLookRest_px = 1.5f;       // what flow over the coarse levels may leave over

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
  next_bin_ = 0;
  for (uint8_t& wait : bin_wait_) wait = 0;
  residual_usual_ = 0;
}

void Frontend::predict(const Mat3& R_C1C0) {
  for (Track& track : tracks_) {
    track.x_turned = track.x;
    track.y_turned = track.y;
    Vec3 bearing_C0;
    Vec2 uv;
    if (camera_.unproject(Vec2(track.x, track.y), bearing_C0) &&
        camera_.project(R_C1C0 * bearing_C0, uv)) {
      track.x_turned = static_cast<float>(uv.x());
      track.y_turned = static_cast<float>(uv.y());
    }
    track.x_pred = track.x_turned + track.x_parallax;
    track.y_pred = track.y_turned + track.y_parallax;
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
  residual_usual_ = *middle;
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

// First against the track's first look, which does not drift, from where it is expected and then
// from where flow over the pyramid leads; only where it does not fit any more, against the previous
// image, and the track gets a new first look.
bool Frontend::follow_one(Track& track, float& residual, TrackLoss& why) {
  const PyramidStore& to = pyramid_[current_];
  float x = track.x_pred, y = track.y_pred;
  why = TrackLoss::kLeftImage;
  if (!inside(to.level(0), x, y, 0)) {  // by its parallax perhaps, which need not go on
    x = track.x_turned;
    y = track.y_turned;
    if (!inside(to.level(0), x, y, 0)) return false;
  }
  bool by_look = follow_look(track, params_.look_shift_px_max, x, y, residual);
  if (!by_look) {
    for (int l = to.levels() - 1; l > 0; --l) {
      (void)follow_level(track, l, x, y, residual, why);  // only the finest must succeed
    }
    by_look = follow_look(track, kLookRest_px, x, y, residual);
  }
  if (!by_look) {
    why = TrackLoss::kLeftImage;
    if (!follow_level(track, 0, x, y, residual, why)) return false;
    if (!inside(to.level(0), x, y, kFollowMargin_px)) return false;
    why = TrackLoss::kResidual;
    if (residual > params_.lk_residual_grey_max) return false;
    why = TrackLoss::kReturn;
    if (!returns(track, x, y)) return false;
  }
  track.x_parallax = x - track.x_turned;
  track.y_parallax = y - track.y_turned;
  track.x_last = track.x;
  track.y_last = track.y;
  track.x = track.x_pred = track.x_turned = x;
  track.y = track.y_pred = track.y_turned = y;
  if (track.age < UINT16_MAX) ++track.age;
  if (!by_look) looks_.begin(track, to.level(0));
  return true;
}

bool Frontend::follow_look(const Track& track, float shift_px_max, float& x, float& y,
                           float& residual) {
  const ImageView& image = pyramid_[current_].level(0);
  float x_found = x, y_found = y;
  const FirstLooks::Limits limits{
      shift_px_max,
      std::min(
          params_.lk_residual_grey_max,
          std::max(kLookResidualAlways_grey, params_.look_residual_ratio_max * residual_usual_)),
      static_cast<int>(params_.lk_iterations_max), params_.lk_step_px_min};
  if (!looks_.follow(track, image, limits, x_found, y_found, residual)) return false;
  if (!inside(image, x_found, y_found, kFollowMargin_px)) return false;
  x = x_found;
  y = y_found;
  return true;
}

// Flow from the previous image over one level of the pyramid, in pixels of the finest.
bool Frontend::follow_level(const Track& track, int level, float& x, float& y, float& residual,
                            TrackLoss& why) const {
  const float scale = 1.0f / static_cast<float>(1 << level);
  LkPatch patch;
  const ImageView& from = pyramid_[current_ ^ 1].level(level);
  if (!lk_extract(from, track.x * scale, track.y * scale, patch) || !patch.usable) return false;
  float xl = x * scale, yl = y * scale;
  const float step = level == 0 ? params_.lk_step_px_min : 2 * params_.lk_step_px_min;
  if (!lk_align(pyramid_[current_].level(level), patch, xl, yl,
                static_cast<int>(params_.lk_iterations_max), step, residual)) {
    why = TrackLoss::kFlow;
    return false;
  }
  x = xl / scale;
  y = yl / scale;
  return true;
}

// Flow back from x, y ends where the track was.
bool Frontend::returns(const Track& track, float x, float y) const {
  LkPatch patch;
  float back_x = track.x, back_y = track.y, residual = 0;
  return lk_extract(pyramid_[current_].level(0), x, y, patch) && patch.usable &&
         lk_align(pyramid_[current_ ^ 1].level(0), patch, back_x, back_y, 3, params_.lk_step_px_min,
                  residual) &&
         squared_distance(track, back_x, back_y) <=
             params_.lk_return_px_max * params_.lk_return_px_max;
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
  // A few for each track that is missing, going on where the last image has ended: of all that are
  // empty, most would be searched for nothing. Those that follow each other lie all over the image.
  const int bins = columns * rows, first = next_bin_;
  const int stride = bins % kBinStride == 0 ? 1 : kBinStride;
  size_t searches = kSearchesPerTrack * (target - tracks_.size());
  for (int i = 0; i < bins; ++i) {
    const int b = (first + i * stride) % bins;
    if (taken[b]) continue;
    if (bin_wait_[b] > 0) {
      --bin_wait_[b];
      continue;
    }
    if (searches == 0) continue;
    --searches;
    next_bin_ = (b + stride) % bins;
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
  track->x = track->x_pred = track->x_turned = x;
  track->y = track->y_pred = track->y_turned = y;
  if (descriptor != nullptr) {
    track->descriptor = *descriptor;
    track->described = true;
  }
  looks_.begin(*track, pyramid_[current_].level(0));
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
