// Template of each track, the patch it began with, and its affine deformation since: alignment with
// it does not drift from image to image.
// In      tracks of one front-end; images of its camera; where a track is expected.
// Out     the track's place in an image, with the residual there.
// Frames  distorted pixels, (0,0) = centre of the first pixel.
// Errors  follow() is false where the patch does not fit any more, for whatever reason: the caller
//         finds the track otherwise and lets it begin anew, since what is known of its deformation
//         may have gone wrong, too.
// Cost    ~0.5 us a track, 1 us more when its template has to be drawn again, x86-64; 0.8 MB.
// Source  Shi, Tomasi, CVPR 1994, section 3; core/kernels/lk/deform.h.
#pragma once

#include "core/kernels/lk/deform.h"
#include "modules/frontend/frontend_params.h"
#include "modules/frontend/track_table.h"

namespace pirvs {

class FirstLooks {
 public:
  void begin(const Track& track, const ImageView& image);

  struct Limits {
    float shift_px;  // from the expected place
    float residual_grey;
    int iterations;
    float step_px;
  };
  bool follow(const Track& track, const ImageView& image, const Limits& limits, float& x, float& y,
              float& residual);

 private:
  struct Look {
    bool usable = false;
    KeyPatch key;
    Deformation deformation;
    DeformedPatch now;  // as it was expected when it was last drawn
  };
  static bool draw(Look& look);

  TrackTable<Look> looks_;
};

}  // namespace pirvs
