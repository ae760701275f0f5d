// What the sensor door hands out, one thing at a time.
// Frames  B. Units: ns on the IMU's clock.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include "modules/door/arrival.h"
#include "modules/door/door_loss.h"

namespace pirvs {

struct DoorFrame {
  TimeNs t = 0;  // on the IMU's clock
  StereoFrame images;
};

enum class DoorItemKind : uint8_t { kImu, kFrame, kGnss, kWheel, kEdge, kCommand, kEvent };

struct DoorItem {
  DoorItemKind kind = DoorItemKind::kImu;
  bool broken = false;  // kImu: time does not go on from the item before
  ImuSample imu;
  DoorFrame frame;
  GnssFix gnss;
  WheelSample wheel;
  bsp::GpioEdge edge;
  Command command;
  DoorLoss event = DoorLoss::kCount;  // kEvent: what health shall tell

  bool is_frame() const { return kind == DoorItemKind::kFrame; }
  bool is_imu() const { return kind == DoorItemKind::kImu; }
};

}  // namespace pirvs
