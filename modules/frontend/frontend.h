// Follows scene points from image to image in one camera: one point keeps one TrackId.
// In      8-bit grey images of one size; a predicted place for each track; gravity in C for the
//         orientation of descriptors.
// Out     tracks(): at most kTracksMax, distorted pixels, (0,0) = centre of the first pixel.
// Frames  C: this camera (x right, y down, z forward).
// Errors  kBadData: image of another size, or not newer than the last; nothing changes.
// Cost    ~0.9 ms a 752 x 480 image on x86-64 (make bench K=frontend).
// Source  PIRVS paper, section IV.A; Baker, Matthews, IJCV 2004, section 3.2 (flow);
//         Shi, Tomasi, CVPR 1994 (corners).
#pragma once

#include "core/base/limits.h"
#include "core/base/status.h"
#include "core/base/time.h"
#include "core/camera/camera.h"
#include "core/kernels/describe/describe.h"
#include "core/kernels/image.h"
#include "core/store/fixed_vector.h"
#include "core/store/pool.h"
#include "modules/frontend/frontend_params.h"
#include "modules/frontend/pyramid_store.h"

namespace pirvs {

using TrackId = uint32_t;  // 0: none

struct Landmark;  // modules/map; to the front-end an association is an opaque tag
using LandmarkId = Handle<Landmark>;

struct Track {
  TrackId id = 0;
  LandmarkId landmark;           // the scene point it was matched to; flow passes it on
  float x = 0, y = 0;            // where it is now
  float x_last = 0, y_last = 0;  // where it was in the previous image
  float x_pred = 0, y_pred = 0;  // where it is expected in the next image
  uint16_t age = 0;              // images since it was detected
  uint8_t misses = 0;            // consecutive images in which its landmark was gated out
  bool described = false;
  // Kept by standstill detection: its place, how long it has been there (-1: not yet begun), where
  // that was when it began to stand, and how often it left a place since it last stood.
  float x_still = 0, y_still = 0, still_s = -1;
  float x_stood = 0, y_stood = 0;
  uint8_t moves = 0;
  Descriptor descriptor{};
};

inline constexpr int kTracksMax = 256;
using Tracks = FixedVector<Track, kTracksMax>;

enum class TrackLoss : uint8_t { kLeftImage, kFlow, kResidual, kReturn, kSpacing, kCount };
const char* name(TrackLoss loss);

class Frontend {
 public:
  void configure(const Camera& camera, const FrontendParams& params);
  void reset();

  // Expects every track where the camera's turn alone would bring it.
  void predict(const Mat3& R_C1C0);
  // Follows, drops, detects and describes. gravity_C: any length; its image direction is "up" for
  // descriptors, so that they survive a roll of the device.
  Status process(const ImageView& image, TimeNs t, const Vec3& gravity_C);

  // The caller may erase tracks and set their x_pred, y_pred between two images.
  Tracks& tracks() { return tracks_; }
  const Tracks& tracks() const { return tracks_; }
  // Starts a track at a place found otherwise (stereo). 0 when full or at the image's edge.
  TrackId start_track(float x, float y, const Descriptor* descriptor);
  // Nearest track within radius_px of a place, or nullptr.
  Track* nearest(float x, float y, float radius_px);

  const PyramidStore& pyramid() const { return pyramid_[current_]; }
  const uint32_t* losses() const { return losses_; }

 private:
  void follow();
  bool follow_one(Track& track, TrackLoss& why);
  void space_out();
  void detect(const Vec3& gravity_C);
  void describe_track(Track& track, const Vec3& gravity_C) const;

  Camera camera_{};
  FrontendParams params_{};
  PyramidStore pyramid_[2];
  int current_ = 0;
  bool has_image_ = false;
  TimeNs t_ = 0;
  TrackId next_id_ = 1;
  Tracks tracks_;
  uint32_t losses_[static_cast<int>(TrackLoss::kCount)] = {};
  static constexpr int kBinsMax = kImagePixelsMax / (kBinMin_px * kBinMin_px);
  uint8_t bin_wait_[kBinsMax] = {};
};

}  // namespace pirvs
