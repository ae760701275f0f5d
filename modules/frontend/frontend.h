// Follows scene points from image to image in one camera: one point keeps one TrackId.
// In      8-bit grey images of one size; a predicted place for each track; gravity in C for the
//         orientation of descriptors.
// Out     tracks(): at most kTracksMax, distorted pixels, (0,0) = centre of the first pixel.
// Frames  C: this camera (x right, y down, z forward).
// Errors  kBadData: image of another size, or not newer than the last; nothing changes.
// Cost    ~0.9 ms a 752 x 480 image on x86-64 (make bench K=frontend).
// Source  PIRVS paper, section IV.A; Baker, Matthews, IJCV 2004, section 3.2 (flow);
//         Shi, Tomasi, CVPR 1994 (corners, and the first look: docs/adr/0016).
#pragma once

#include "core/base/counter.h"
#include "core/base/status.h"
#include "core/base/time.h"
#include "core/camera/camera.h"
#include "core/kernels/image.h"
#include "core/store/fixed_vector.h"
#include "modules/frontend/first_look.h"
#include "modules/frontend/frontend_params.h"
#include "modules/frontend/pyramid_store.h"
#include "modules/frontend/track.h"

namespace pirvs {

enum class TrackLoss : uint8_t { kLeftImage, kFlow, kResidual, kReturn, kSpacing, kCount };
const char* name(TrackLoss loss);

// The cells in which corners are looked for: an image without the margin that describe() needs.
struct DetectionGrid {
  int side_px = 0, columns = 0, rows = 0;
};
inline constexpr int kDetectionCellsMax = 2048;
// Cells of the wanted side; larger ones where more than kDetectionCellsMax would be needed, smaller
// ones where not a single one fits, none where the image is all margin.
DetectionGrid detection_grid(int width, int height, int side_px);

class Frontend {
 public:
  void configure(const Camera& camera, const FrontendParams& params);
  void reset();
  // Other parameters from the next image on; tracks go on.
  void retune(const FrontendParams& params);

  // Expects every track where the camera's turn would bring it, moved on as in the last image by
  // what turning did not explain.
  void predict(const Mat3& R_C1C0);
  // Follows, drops, detects and describes. gravity_C: any length; its image direction is "up" for
  // descriptors, so that they survive a roll of the device.
  Status process(const ImageView& image, TimeNs t, const Vec3& gravity_C);

  const Tracks& tracks() const { return tracks_; }
  // Track i, to say between two images where it is expected, or that its place or descriptor is
  // another.
  Track& track(size_t i) { return tracks_[i]; }
  // Ends track i; the last one takes its place in tracks().
  void erase(size_t i);
  // Starts a track at a place found otherwise (stereo). 0 when full or at the image's edge.
  TrackId start_track(float x, float y, const Descriptor* descriptor);
  // Nearest track within radius_px of a place, or nullptr.
  Track* nearest(float x, float y, float radius_px);

  const PyramidStore& pyramid() const { return pyramid_[current_]; }
  const CounterArray<TrackLoss>& losses() const { return losses_; }

 private:
  void follow();
  bool follow_one(Track& track, float& residual, TrackLoss& why);
  bool follow_look(const Track& track, float shift_px_max, float& x, float& y, float& residual);
  bool follow_level(const Track& track, int level, float& x, float& y, float& residual,
                    TrackLoss& why) const;
  bool returns(const Track& track, float x, float y) const;
  void drop_misfits(const FixedVector<float, kTracksMax>& residuals);
  void space_out();
  void detect(const Vec3& gravity_C);
  void describe_track(Track& track, const Vec3& gravity_C) const;
  void release(const Track& track);

  Camera camera_{};
  FrontendParams params_{};
  PyramidStore pyramid_[2];
  int current_ = 0;
  bool has_image_ = false;
  TimeNs t_ = 0;
  TrackId next_id_ = 1;
  Tracks tracks_;
  FirstLooks looks_;
  float residual_usual_ = 0;                      // median over the tracks of the last image
  FixedVector<uint16_t, kTracksMax> free_slots_;  // of no track, the next one's last
  CounterArray<TrackLoss> losses_;
  DetectionGrid grid_;
  int next_bin_ = 0;  // to be searched, if it is empty
  uint8_t bin_wait_[kDetectionCellsMax] = {};
};

}  // namespace pirvs
