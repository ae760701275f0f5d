#include "modules/recorder/order_row.h"

namespace pirvs {
namespace {

void put_fix(TextWriter& text, const GnssFix& fix) {
  text.number(fix.t).put(',').number(static_cast<int64_t>(fix.type));
  for (const double value : {fix.latitude_deg, fix.longitude_deg, fix.height_m,
                             fix.sigma_horizontal_m, fix.sigma_vertical_m}) {
    text.put(',').exact(value);
  }
  text.put(fix.has_velocity ? ",1" : ",0");
  for (int i = 0; i < 3; ++i) text.put(',').exact(fix.v_ned[i]);
  text.put(',').exact(fix.sigma_velocity_m_s);
}

void put_wheel(TextWriter& text, const WheelSample& wheel) {
  text.number(wheel.t).put(',').number(static_cast<int64_t>(wheel.kind));
  for (const double value : wheel.value) text.put(',').exact(value);
}

void put_edge(TextWriter& text, const bsp::GpioEdge& edge) {
  text.number(edge.t).put(',').number(edge.pin.bank).put(',').number(edge.pin.line);
  text.put(edge.level ? ",1" : ",0");
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
  out.kind = arrival.kind;
  out.sensor = arrival.sensor;
  out.status = arrival.status;
  out.after_loss = arrival.after_loss;
  out.t = arrival.t;
  if (arrival.kind == ArrivalKind::kImu) out.t = arrival.imu.t;
  if (arrival.kind == ArrivalKind::kFrame) {
    out.t = arrival.frame.t;
    out.present = arrival.frame.present;
    out.lost_before = arrival.frame.lost_before;
    for (int c = 0; c < kCamerasMax; ++c) out.late[c] = arrival.frame.late[c];
  }
  out.gnss = arrival.gnss;
  out.wheel = arrival.wheel;
  out.edge = arrival.edge;
  out.command = arrival.command;
  return out;
}

Arrival arrival_of(const OrderRow& row) {
  Arrival out;
  out.kind = row.kind;
  out.sensor = row.sensor;
  out.status = row.status;
  out.after_loss = row.after_loss;
  out.t = row.t;
  out.gnss = row.gnss;
  out.wheel = row.wheel;
  out.edge = row.edge;
  out.command = row.command;
  return out;
}

void put(TextWriter& text, const OrderRow& row) {
  text.put(kOrderKinds[static_cast<int>(row.kind)]).put(',');
  switch (row.kind) {
    case ArrivalKind::kImu:
      text.number(row.t).put(row.after_loss ? ",1" : ",0");
      break;
    case ArrivalKind::kFrame:
      text.number(row.t).put(',').number(row.present);
      for (const TimeNs late : row.late) text.put(',').number(late);
      text.put(',').number(row.lost_before);
      break;
    case ArrivalKind::kGnss:
      put_fix(text, row.gnss);
      break;
    case ArrivalKind::kWheel:
      put_wheel(text, row.wheel);
      break;
    case ArrivalKind::kEdge:
      put_edge(text, row.edge);
      text.put(row.after_loss ? ",1" : ",0");
      break;
    case ArrivalKind::kCommand:
      put_command(text, row.command);
      break;
    case ArrivalKind::kTick:
      text.number(row.t);
      break;
    case ArrivalKind::kFault:
      text.put(kSensorNames[static_cast<int>(row.sensor)]).put(',').put(fault_name(row.status));
      break;
    case ArrivalKind::kLost:
    case ArrivalKind::kBack:
    case ArrivalKind::kEnd:
      text.put(kSensorNames[static_cast<int>(row.sensor)]);
      break;
    case ArrivalKind::kCount:
      break;
  }
  text.put('\n');
}

}  // namespace pirvs
