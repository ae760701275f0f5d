#include "modules/frontend/first_look.h"

#include <cmath>

namespace pirvs {
namespace {

constexpr float kDamping = 10.0f;    // grey^2 / px^2: texture of 3 grey / px is held half
constexpr float kDrawAgain = 0.05f;  // of deformation: 0.35 px at the edge of the patch
constexpr float kContrastAgain = 0.06f;

bool drifted(const Deformation& now, const Deformation& drawn) {
  const float xx = now.xx - drawn.xx, xy = now.xy - drawn.xy;
  const float yx = now.yx - drawn.yx, yy = now.yy - drawn.yy;
  return xx * xx + xy * xy + yx * yx + yy * yy > kDrawAgain * kDrawAgain ||
         std::fabs(now.contrast - drawn.contrast) > kContrastAgain * drawn.contrast;
}

}  // namespace

void FirstLooks::begin(const Track& track, const ImageView& image) {
  Look& look = looks_[track];
  look.deformation = Deformation{};
  look.usable = key_patch(image, track.x, track.y, look.key) && draw(look);
}

bool FirstLooks::draw(Look& look) { return deform(look.key, look.deformation, kDamping, look.now); }

bool FirstLooks::follow(const Track& track, const ImageView& image, const Limits& limits, float& x,
                        float& y, float& residual) {
  Look& look = looks_[track];
  if (!look.usable) return false;
  float x_found = x, y_found = y, left_over = 0;
  if (!lk_align(image, look.now.lk, x_found, y_found, limits.iterations, limits.step_px,
                left_over)) {
    return false;
  }
  const float dx = x_found - x, dy = y_found - y;
  if (!(dx * dx + dy * dy < limits.shift_px * limits.shift_px)) return false;
  if (left_over > limits.residual_grey) return false;
  if (!deform_step(image, look.now, x_found, y_found, look.deformation)) return false;
  if (drifted(look.deformation, look.now.deformation)) look.usable = draw(look);
  x = x_found;
  y = y_found;
  residual = left_over;
  return true;
}

}  // namespace pirvs
