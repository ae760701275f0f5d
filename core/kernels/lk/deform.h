// Affine template tracking: warps the patch that a track began with to how it should look now, and
// refines position, affine deformation and contrast. Flow from image to image accumulates drift;
// alignment with the first template does not.
// In      8-bit grey. A key patch and its deformation since; positions in pixels of the image.
// Out     deform: the template for lk_align as the key patch should look now, with the normal
//         equations of the joint step. deform_step: one Gauss-Newton step of place, deformation and
//         contrast together, from where lk_align has ended.
// Frames  Pixels, x right, y down, (0,0) = centre of the first pixel. Offset from the patch's
//         centre in the image of now = [xx xy; yx yy] * offset in the key patch.
// Errors  false: key_patch: the place is outside the image. deform: the deformation asks for more
//         than the key patch has around it, or is none (deform_usable), or too flat a template.
//         deform_step: the window leaves the image, or the step is too large to be true.
// Cost    x86-64: 1.2 us a deform, 0.17 us a step (make bench K=deform).
//         All variants and machines give the same bits: sums are integers, the rest is a fixed
//         order of float operations.
// Goal    A72 cycles: deform 9000 a call, deform_step 900.
// Source  Shi, Tomasi, CVPR 1994, section 3 (affine consistency with the first image); Baker,
//         Matthews, IJCV 2004, section 3.2.1 (inverse composition).
#pragma once

#include "core/kernels/lk/lk.h"

namespace pirvs {

inline constexpr int kKeySide = 36;  // px: a template turned by any angle, or scaled by 0.55

struct KeyPatch {
  uint8_t grey[kKeySide * kKeySide];  // outside of the image its edge is repeated
  float x, y;                         // of the point, in this patch
};

struct Deformation {
  float xx = 1, xy = 0, yx = 0, yy = 1;
  float contrast = 1;
};

inline constexpr int kDeformUnknowns = 7;  // x, y, xx, xy, yx, yy, contrast

struct DeformedPatch {
  LkPatch lk;
  Deformation deformation;
  int16_t mean;                                      // of the template, grey * 32
  int32_t sums[kDeformUnknowns];                     // of the derivatives over the patch
  float factors[kDeformUnknowns * kDeformUnknowns];  // lower triangle: Cholesky
};

bool key_patch(const ImageView& im, float x, float y, KeyPatch& out);
// No mirror image, no more than twice or half the area, twice the contrast, twice as long as wide.
bool deform_usable(const Deformation& d);
// `damping`: grey^2 / px^2, what holds the deformation where the texture does not tell it.
bool deform_ref(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out);
bool deform_neon(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out);
// Corrects d, the track's deformation; the template may have been drawn for a slightly older one.
bool deform_step_ref(const ImageView& im, const DeformedPatch& patch, float& x, float& y,
                     Deformation& d);
bool deform_step_neon(const ImageView& im, const DeformedPatch& patch, float& x, float& y,
                      Deformation& d);

inline bool deform(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out) {
  return deform_neon(key, d, damping, out);
}
inline bool deform_step(const ImageView& im, const DeformedPatch& patch, float& x, float& y,
                        Deformation& d) {
  return deform_step_neon(im, patch, x, y, d);
}

}  // namespace pirvs
