#include "modules/recorder/order_row.h"

namespace pirvs {
namespace {

OrderKind kind_of(ArrivalKind kind) {
  switch (kind) {
    case ArrivalKind::kImu:
      return OrderKind::kImu;
    case ArrivalKind::kFrame:
      return OrderKind::kFrame;
    case ArrivalKind::kTick:
      return OrderKind::kTick;
    case ArrivalKind::kCommand:
      return OrderKind::kCommand;
    case ArrivalKind::kFault:
      return OrderKind::kFault;
    case ArrivalKind::kEnd:
      return OrderKind::kEnd;
    case ArrivalKind::kLost:
    case ArrivalKind::kBack:
    case ArrivalKind::kGnss:
    case ArrivalKind::kWheel:
    case ArrivalKind::kEdge:
    case ArrivalKind::kCount:
      break;
  }
  return OrderKind::kNone;
}

void put_command(TextWriter& text, const Command& command) {
  text.number(static_cast<int64_t>(command.kind)).put(',');
  text.exact(static_cast<double>(command.value)).put(',').exact(command.yaw_rad);
  for (int i = 0; i < 3; ++i) text.put(',').exact(command.p_WB[i]);
  text.put(",x");
  static constexpr char kDigits[] = "0123456789abcdef";
  for (int i = 0; i < Command::kTextMax && command.text[i] != 0; ++i) {
    const auto byte = static_cast<unsigned char>(command.text[i]);
    text.put(kDigits[byte >> 4]).put(kDigits[byte & 15]);
  }
}

}  // namespace

const char* fault_name(Status status) {
  if (status == Status::kBusFault) return "bus_fault";
  return status == Status::kTimeout ? "timeout" : "bad_data";
}

OrderRow order_row_of(const Arrival& arrival) {
  OrderRow out;
  out.kind = kind_of(arrival.kind);
  out.sensor = arrival.sensor;
  out.status = arrival.status;
  out.after_loss = arrival.after_loss;
  out.t = arrival.t;
  if (arrival.kind == ArrivalKind::kImu) out.t = arrival.imu.t;
  if (arrival.kind == ArrivalKind::kFrame) {
    out.t = arrival.frame.t;
    out.present = arrival.frame.present;
    for (int c = 0; c < 2; ++c) out.late[c] = arrival.frame.late[c];
  }
  if (arrival.kind == ArrivalKind::kCommand) out.command = arrival.command;
  return out;
}

void put(TextWriter& text, const OrderRow& row) {
  if (row.kind == OrderKind::kNone) return;
  text.put(kOrderKinds[static_cast<int>(row.kind)]).put(',');
  switch (row.kind) {
    case OrderKind::kImu:
      text.number(row.t).put(row.after_loss ? ",1" : ",0");
      break;
    case OrderKind::kFrame:
      text.number(row.t).put(',').number(row.present);
      for (const TimeNs late : row.late) text.put(',').number(late);
      break;
    case OrderKind::kCommand:
      put_command(text, row.command);
      break;
    case OrderKind::kFault:
      text.put(kSensorNames[static_cast<int>(row.sensor)]).put(',').put(fault_name(row.status));
      break;
    case OrderKind::kEnd:
      text.put(kSensorNames[static_cast<int>(row.sensor)]);
      break;
    default:
      text.number(row.t);
  }
  text.put('\n');
}

}  // namespace pirvs
