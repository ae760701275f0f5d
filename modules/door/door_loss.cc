#include "modules/door/door_loss.h"

#include <iterator>

namespace pirvs {

const char* name(DoorLoss loss) {
  static constexpr const char* kNames[] = {"imu_not_finite",
                                           "imu_out_of_range",
                                           "imu_stamp_impossible",
                                           "imu_saturated",
                                           "imu_spike",
                                           "imu_stuck",
                                           "imu_stamp_ahead",
                                           "imu_backwards",
                                           "imu_lost",
                                           "imu_gap",
                                           "imu_silent",
                                           "imu_clock_back",
                                           "stream_broken",
                                           "frames_lost",
                                           "frame_stamp_impossible",
                                           "frame_backwards",
                                           "frame_before_imu",
                                           "frame_without_imu",
                                           "frame_ahead",
                                           "camera_missing",
                                           "camera_late",
                                           "camera_frozen",
                                           "camera_wrong_size",
                                           "camera_silent",
                                           "camera_gap",
                                           "camera_clock_set",
                                           "imu_clock_set",
                                           "imu_queue_full",
                                           "aside_stamp_impossible",
                                           "aside_before_imu",
                                           "aside_full",
                                           "edges_lost",
                                           "imu_bus_fault",
                                           "imu_timeout",
                                           "imu_bad_data",
                                           "imu_lost_device",
                                           "imu_back",
                                           "camera_bus_fault",
                                           "camera_timeout",
                                           "camera_bad_data",
                                           "camera_lost_device",
                                           "camera_back"};
  static_assert(std::size(kNames) == static_cast<size_t>(DoorLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

const char* message(DoorLoss loss) {
  switch (loss) {
    case DoorLoss::kImuSilent:
      return "the IMU is silent";
    case DoorLoss::kFramesLost:
      return "the cameras' driver loses frames";
    case DoorLoss::kImuBusFault:
    case DoorLoss::kImuTimeout:
    case DoorLoss::kImuBadData:
      return "the IMU's driver reports faults";
    case DoorLoss::kImuLostDevice:
      return "the IMU is lost";
    case DoorLoss::kImuBack:
      return "the IMU is back";
    case DoorLoss::kCameraBusFault:
    case DoorLoss::kCameraTimeout:
    case DoorLoss::kCameraBadData:
      return "the cameras' driver reports faults";
    case DoorLoss::kCameraLostDevice:
      return "the cameras are lost";
    case DoorLoss::kCameraBack:
      return "the cameras are back";
    default:
      return name(loss);
  }
}

}  // namespace pirvs
