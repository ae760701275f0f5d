// Tells whether gyro and image turn alike: axes that are exchanged, mirrored or of another sign
// show there, before any start, and where one camera alone would find none.
// In      tracks of a camera from one frame to the next, and how far the gyro says that B turned.
// Out     gain(): image turn = gain * gyro turn, as far as the turns so far tell; against().
// Frames  B. Units: rad.
// Errors  none. Axes about which nothing has turned unevenly have the gain 0.
// Cost    ~10 us a frame, x86-64.
// Source  own. A circle about what is near lets the image turn against the gyro, too: the flow of a
//         translation looks like a turn. How the rates change from frame to frame is compared,
//         which a steady circle has no part in.
#pragma once

#include "core/camera/camera.h"
#include "modules/frontend/track.h"

namespace pirvs {

class TurnCheck {
 public:
  // `turn_B`: the rotation vector from the last frame to this one.
  void add(const Camera& camera, const Tracks& tracks, const Vec3& turn_B, double dt_s);
  Mat3 gain() const;
  bool against() const;

 private:
  bool turn_of_image(const Camera& camera, const Tracks& tracks, Vec3& turn_B) const;

  struct Rates {
    Vec3 image_B, gyro_B;
  };
  Rates last_{};
  bool has_last_ = false;
  Mat3 cross_ = Mat3::Zero();  // of image and gyro, of the changes of their rates, (rad/s)^2
  Mat3 gyro_ = Mat3::Zero();
};

}  // namespace pirvs
