// One thing that comes to the sensor door: what it is, and the thing itself. The sequence of
// arrivals is all that the door decides by, so whoever has it can have the run again.
// Units   ns.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include <cstdint>

#include "bsp/api/camera.h"
#include "bsp/api/gpio.h"
#include "bsp/api/imu.h"
#include "core/base/status.h"
#include "modules/door/command.h"
#include "modules/door/items.h"

namespace pirvs {

enum class Sensor : uint8_t { kImu, kCamera, kCount };

enum class ArrivalKind : uint8_t {
  kImu,
  kFrame,
  kGnss,
  kWheel,
  kEdge,
  kCommand,
  kTick,   // time passes: t on the machine's clock, which judges silence
  kFault,  // `sensor`'s driver answered `status` in place of an item
  kLost,   // the driver says that `sensor` is gone
  kBack,   // ... and that it is there again
  kEnd,    // `sensor` will send nothing more
  kCount
};

struct Arrival {
  ArrivalKind kind = ArrivalKind::kTick;
  Sensor sensor = Sensor::kImu;  // kFault, kLost, kBack, kEnd
  Status status = Status::kOk;   // kFault
  bool after_loss = false;       // kImu, kEdge: the driver lost some before this one, which is good
  TimeNs t = 0;                  // kTick
  ImuSample imu;
  StereoFrame frame;
  GnssFix gnss;
  WheelSample wheel;
  bsp::GpioEdge edge;
  Command command;
};

inline Arrival arrival_of(const ImuSample& sample, bool after_loss = false) {
  Arrival out;
  out.kind = ArrivalKind::kImu;
  out.after_loss = after_loss;
  out.imu = sample;
  return out;
}

inline Arrival arrival_of(const StereoFrame& frame) {
  Arrival out;
  out.kind = ArrivalKind::kFrame;
  out.frame = frame;
  return out;
}

inline Arrival arrival_of(const GnssFix& fix) {
  Arrival out;
  out.kind = ArrivalKind::kGnss;
  out.gnss = fix;
  return out;
}

inline Arrival arrival_of(const WheelSample& wheel) {
  Arrival out;
  out.kind = ArrivalKind::kWheel;
  out.wheel = wheel;
  return out;
}

inline Arrival arrival_of(const bsp::GpioEdge& edge, bool after_loss = false) {
  Arrival out;
  out.kind = ArrivalKind::kEdge;
  out.after_loss = after_loss;
  out.edge = edge;
  return out;
}

inline Arrival arrival_of(const Command& command) {
  Arrival out;
  out.kind = ArrivalKind::kCommand;
  out.command = command;
  return out;
}

inline Arrival arrival_of(ArrivalKind kind, Sensor sensor, Status status = Status::kOk) {
  Arrival out;
  out.kind = kind;
  out.sensor = sensor;
  out.status = status;
  return out;
}

inline Arrival tick_at(TimeNs t) {
  Arrival out;
  out.t = t;
  return out;
}

}  // namespace pirvs
