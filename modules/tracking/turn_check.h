// Compares the rotation that the gyro measures with the rotation of the image. Axes of the IMU that
// are exchanged, mirrored or of another sign show there, also before any start.
// In      tracks of a camera from one frame to the next, and how far the gyro says that B turned.
// Out     gain(): image turn = gain * gyro turn, as far as the turns so far tell; against().
// Frames  B. Units: rad.
// Errors  none. Axes about which nothing has turned unevenly have the gain 0.
// Cost    ~10 us a frame, x86-64.
// Source  own. Translation, too, makes flow that looks like a rotation: on a circle around a near
//         object the image even turns against the gyro. So the changes of both rates from frame to
//         frame are compared, to which a steady circle adds nothing.
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
