// The sensor door: one stream, ordered by sensor time, on the IMU's clock.
// In      bsp::imu_poll and bsp::camera_poll, each in its own order.
// Out     next(): IMU samples, then a frame once a sample exactly at its time has been handed out
//         (interpolated when the IMU has none there).
// Units   ns, rad/s, m/s^2.
// Errors  kEmpty: nothing now. kStale: the sensors have ended. Bad samples are dropped and counted.
// Cost    negligible. Source: docs/architecture.md.
#pragma once

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"

namespace pirvs {

enum class DoorLoss : uint8_t {
  kImuNotFinite,
  kImuOutOfRange,
  kImuBackwards,
  kImuLost,
  kImuGap,
  kFrameBackwards,
  kFrameBeforeImu,
  kFrameWithoutImu,
  kCameraMissing,
  kCount
};
const char* name(DoorLoss loss);

struct DoorFrame {
  TimeNs t = 0;  // on the IMU's clock
  StereoFrame images;
};

struct DoorItem {
  bool is_frame = false;
  ImuSample imu;
  DoorFrame frame;
};

class Door {
 public:
  void configure(TimeNs camera_time_offset);
  // A frame handed out stays valid until release().
  Status next(DoorItem& out);
  void release();
  const uint32_t* losses() const { return losses_; }

 private:
  bool fetch_imu();
  bool fetch_frame();
  void drop_frame(DoorLoss why);
  void count(DoorLoss loss) { ++losses_[static_cast<int>(loss)]; }

  TimeNs offset_ = 0;
  ImuSample last_;  // handed out
  bool has_last_ = false;
  ImuSample ahead_;  // fetched, not handed out
  bool has_ahead_ = false;
  DoorFrame frame_;
  bool has_frame_ = false;
  TimeNs last_frame_t_ = INT64_MIN;
  bool imu_ended_ = false, frames_ended_ = false;
  uint32_t losses_[static_cast<int>(DoorLoss::kCount)] = {};
};

}  // namespace pirvs
