// Auto-exposure: from the images of a frame to one exposure time and gain of all cameras.
// In      frame(): each frame's images, in order; its exposure and gain if the camera tells them.
//         turn(): the angular rate. set_range(): what the cameras can do.
// Out     frame(): true: this setting is to be used from now on.
//         Exposure first, up to the least of: longest_s, the period between frames less readout_s,
//         and blur_px of motion at the peak of the angular rate; then gain. An exposure of at least
//         one period of the mains' flicker is a whole multiple of it.
// Units   s, gain as a factor, rad/s, px.
// Errors  None. What the range forbids is not asked for: the image stays too dark or too bright.
// How     An image of a known setting says how much light there is, and so which product of
//         exposure and gain suits it: one step, whatever the delay of the sensor. After a change
//         images are not used until the camera tells that they are of the new setting, or, of a
//         camera that does not tell, until delay_frames later: a step is never judged by images
//         from before it, so that a delay cannot make it oscillate. A step larger than a stop
//         (factor 2) needs two images that agree, but the first after another one; a clear smaller
//         one, too; else the mean light of the last images decides. While the light goes up and
//         down from image to image, nothing but the mean over whole beats does.
// Cost    752 x 480 pair, x86-64 (make bench K=exposure): 6 us; 2820 pixels are read.
// Source  None of literature: deadbeat control of a static plant with dead time.
#pragma once

#include "core/base/time.h"
#include "modules/exposure/brightness.h"
#include "modules/exposure/exposure_params.h"

namespace pirvs {

struct ExposureSetting {
  double exposure_s = 0;
  double gain = 0;

  double product() const { return exposure_s * gain; }
};

struct ExposureRange {
  ExposureSetting min, max, step;
};

struct ExposureFrame {
  TimeNs t = 0;
  const ImageView* images = nullptr;  // those that are missing are empty
  int count = 0;
  ExposureSetting taken;  // with which it was taken; 0: the camera does not tell
};

class AutoExposure {
 public:
  void configure(const ExposureParams& params, double focal_px, double period_s);
  void retune(const ExposureParams& params);
  void set_range(const ExposureRange& range) { range_ = range; }
  void turn(double rate_rad_s);

  bool frame(const ExposureFrame& frame, ExposureSetting& out);
  const ExposureSetting& setting() const { return setting_; }

 private:
  static constexpr int kAveraged = 6, kJudged = 3;  // images, for a small step
  static constexpr int kWindow = 15, kSwingsRemembered = 15,
                       kSwingsJudged = 5;  // under flicker: whole beats of 3 and 5
  static constexpr int kPeriods = 8;       // frames over which their period is measured

  void note_time(TimeNs t);
  bool find_taken(const ExposureFrame& frame, double& product) const;
  double look(const ExposureFrame& frame) const;
  void note_swing(double suits);
  void remember(double suits);
  double mean_of_last(int images) const;
  bool wish(double suits);
  bool want(double product);
  void forget();
  double exposure_max() const;
  ExposureSetting split(double product) const;
  bool blurs() const;

  ExposureParams params_;
  ExposureRange range_;
  double focal_px_ = 0, period_s_ = 0;
  bool period_measured_ = false;
  TimeNs times_[kPeriods] = {};
  int time_count_ = 0;
  double rate_rad_s_ = 0;  // a peak that decays

  ExposureSetting setting_;     // as commanded last; 0: nothing yet
  double wished_ = 0;           // product of exposure and gain that suits the light
  int age_ = 0;                 // images since the last change
  double light_[kWindow] = {};  // 1 over the product that suits each image
  int light_count_ = 0;
  double last_ = 0;                // what suits the image before; 0: none
  bool eager_ = true;              // one image is enough for a large step
  int swings_ = 0;                 // images for which flicker is taken to go on
  int direction_ = 0;              // of the light, from one image to another
  int step_ = 0, since_step_ = 0;  // direction of the last small one, images since
};

}  // namespace pirvs
