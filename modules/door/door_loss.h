// Everything that the sensor door finds wrong with its input, by name; docs/faults.md says what is
// done about each.
#pragma once

#include <cstdint>

#include "core/base/counter.h"

namespace pirvs {

enum class DoorLoss : uint8_t {
  kImuNotFinite,
  kImuOutOfRange,
  kImuStampImpossible,
  kImuSaturated,
  kImuSpike,
  kImuStuck,
  kImuStampAhead,
  kImuBackwards,
  kImuLost,
  kImuGap,
  kImuSilent,
  kImuClockBack,
  kStreamBroken,
  kFramesLost,
  kFrameStampImpossible,
  kFrameBackwards,
  kFrameBeforeImu,
  kFrameWithoutImu,
  kFrameAhead,
  kCameraMissing,
  kCameraLate,
  kCameraFrozen,
  kCameraWrongSize,
  kCameraSilent,
  kCameraGap,
  kCameraClockSet,
  kImuClockSet,
  kImuQueueFull,
  kAsideStampImpossible,
  kAsideBeforeImu,
  kAsideFull,
  kEdgesLost,
  kImuBusFault,
  kImuTimeout,
  kImuBadData,
  kImuLostDevice,
  kImuBack,
  kCameraBusFault,
  kCameraTimeout,
  kCameraBadData,
  kCameraLostDevice,
  kCameraBack,
  kCount
};
const char* name(DoorLoss loss);
// What health tells of it: a sentence for people.
const char* message(DoorLoss loss);

using DoorLosses = CounterArray<DoorLoss>;

}  // namespace pirvs
