// A row of order.csv: one arrival at the door.
// In      Arrivals in their order. Samples and images are in their sensors' tables: the n-th "imu"
//         row is the n-th of imu0/data.csv, and a frame's images are the next ones of each camera
//         that it says is present. All else is whole in its row.
// Out     One line of text: kind, then by kind
//           imu,T,LOST             1: the driver lost samples before this one
//           frame,T,PRESENT,LATE0,LATE1,LOST   frames that the driver lost before this one
//           gnss,T,TYPE,LATITUDE,LONGITUDE,HEIGHT,SIGMA_HORIZONTAL,SIGMA_VERTICAL,
//                HAS_VELOCITY,NORTH,EAST,DOWN,SIGMA_VELOCITY
//           wheel,T,KIND,VALUE0,VALUE1
//           edge,T,BANK,LINE,LEVEL,LOST   1: the driver lost edges before this one
//           command,KIND,VALUE,YAW,X,Y,Z,TEXT   text as hexadecimal bytes behind an "x"
//           tick,T                 T on the machine's clock
//           fault,SENSOR,STATUS    sensor imu or camera; status bus_fault, timeout or bad_data
//           lost,SENSOR
//           back,SENSOR
//           end,SENSOR
// Units   T in ns; the others as in modules/door/items.h. Numbers read back to the bit.
// Errors  none.
// Cost    ~1 us a row (x86-64); 300 bytes in memory.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include <iterator>

#include "core/base/text.h"
#include "modules/door/arrival.h"

namespace pirvs {

// An arrival without its pixels.
struct OrderRow {
  ArrivalKind kind = ArrivalKind::kTick;
  Sensor sensor = Sensor::kImu;
  Status status = Status::kOk;
  bool after_loss = false;
  uint8_t present = 0;
  uint32_t lost_before = 0;
  TimeNs t = 0;
  TimeNs late[kCamerasMax] = {0, 0};
  GnssFix gnss;
  WheelSample wheel;
  bsp::GpioEdge edge;
  Command command;
};

inline constexpr const char* kOrderHeading = "#kind,stamp [ns],more by kind\n";
inline constexpr const char* kOrderKinds[] = {"imu",  "frame", "gnss", "wheel", "edge", "command",
                                              "tick", "fault", "lost", "back",  "end"};
static_assert(std::size(kOrderKinds) == static_cast<size_t>(ArrivalKind::kCount));
inline constexpr const char* kSensorNames[] = {"imu", "camera"};
// Of the faults that a driver reports.
const char* fault_name(Status status);

OrderRow order_row_of(const Arrival& arrival);
// What is whole in its row; of samples and frames all but the item itself.
Arrival arrival_of(const OrderRow& row);
void put(TextWriter& text, const OrderRow& row);  // with the line's end

// The longest row: that of a fix.
inline constexpr size_t kOrderRowMax = 14 * TextWriter::kNumber;

}  // namespace pirvs
