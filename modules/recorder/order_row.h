// A row of order.csv: one arrival at the door, or a decision that arrivals do not determine.
// In      Arrivals in their order. The items themselves are in their sensors' tables: the n-th
//         "imu" row is the n-th of imu0/data.csv, and a frame's images are the next ones of each
//         camera that it says is present.
// Out     One line of text: kind,stamp [ns], and by kind
//           imu,T,LOST             1: the driver lost samples before this one
//           frame,T,PRESENT,LATE0,LATE1
//           tick,T                 T on the machine's clock
//           command,KIND,VALUE,YAW,X,Y,Z,TEXT   text as hexadecimal bytes behind an "x"
//           fault,SENSOR,STATUS    sensor imu or camera; status bus_fault, timeout or bad_data
//           end,SENSOR
//           map,SEQUENCE           the frame in work used mapping's result of this keyframe
// Errors  none. GNSS fixes, wheel samples, edges and what a driver says of a lost device have no
//         row: no intake asks for them yet.
// Cost    ~1 us a row (x86-64); 48 bytes in memory beside a command's 168.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include "core/base/text.h"
#include "modules/door/arrival.h"

namespace pirvs {

enum class OrderKind : uint8_t {
  kImu,
  kFrame,
  kTick,
  kCommand,
  kFault,
  kEnd,
  kMap,
  kNone,  // of an arrival that has no row
};

struct OrderRow {
  OrderKind kind = OrderKind::kNone;
  Sensor sensor = Sensor::kImu;
  Status status = Status::kOk;
  bool after_loss = false;
  uint8_t present = 0;
  TimeNs t = 0;  // kMap: the sequence
  TimeNs late[2] = {0, 0};
  Command command;
};

inline constexpr const char* kOrderHeading = "#kind,stamp [ns],more by kind\n";
inline constexpr const char* kOrderKinds[] = {"imu",   "frame", "tick", "command",
                                              "fault", "end",   "map"};
inline constexpr const char* kSensorNames[] = {"imu", "camera"};
// Of the faults that a driver reports.
const char* fault_name(Status status);

OrderRow order_row_of(const Arrival& arrival);
void put(TextWriter& text, const OrderRow& row);  // with the line's end

}  // namespace pirvs
