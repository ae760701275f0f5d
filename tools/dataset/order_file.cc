#include "tools/dataset/order_file.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// The fields of one row, taken from left to right; any that is wrong makes the row bad.
class Fields {
 public:
  explicit Fields(const std::string& line) {
    std::istringstream in(line);
    for (std::string field; std::getline(in, field, ',');) fields_.push_back(field);
  }
  std::string text() { return at_ < fields_.size() ? fields_[at_++] : (ok_ = false, ""); }
  template <class T>
  T number() {
    const std::string field = text();
    T value{};
    const char* const end = field.data() + field.size();
    const auto result = std::from_chars(field.data(), end, value);
    ok_ = ok_ && result.ec == std::errc() && result.ptr == end;
    return value;
  }
  // A whole number from 0 to max.
  int up_to(int max) {
    const int value = number<int>();
    ok_ = ok_ && value >= 0 && value <= max;
    return ok_ ? value : 0;
  }
  // The index of the next field among names.
  template <size_t N>
  int among(const char* const (&names)[N]) {
    const std::string field = text();
    const auto found = std::find(std::begin(names), std::end(names), field);
    ok_ = ok_ && found != std::end(names);
    return ok_ ? int(found - std::begin(names)) : 0;
  }
  Status fault() {
    const std::string field = text();
    for (const Status status : {Status::kBusFault, Status::kTimeout, Status::kBadData}) {
      if (field == fault_name(status)) return status;
    }
    ok_ = false;
    return Status::kBadData;
  }
  void check(bool ok) { ok_ = ok_ && ok; }
  bool ok() const { return ok_ && at_ == fields_.size(); }

 private:
  std::vector<std::string> fields_;
  size_t at_ = 0;
  bool ok_ = true;
};

void read_text(Fields& fields, Command& command) {
  const std::string hex = fields.text();
  const size_t size = hex.empty() ? 0 : (hex.size() - 1) / 2;
  fields.check(!hex.empty() && hex[0] == 'x' && hex.size() % 2 == 1 && size < Command::kTextMax);
  for (size_t i = 0; i < size && i + 1 < Command::kTextMax; ++i) {
    unsigned byte = 0;
    const char* const begin = hex.data() + 1 + 2 * i;
    fields.check(std::from_chars(begin, begin + 2, byte, 16).ptr == begin + 2);
    command.text[i] = char(byte);
  }
}

Command read_command(Fields& fields) {
  Command out;
  out.kind = CommandKind(fields.up_to(int(CommandKind::kCount) - 1));
  out.value = float(fields.number<double>());
  out.yaw_rad = fields.number<double>();
  for (int i = 0; i < 3; ++i) out.p_WB[i] = fields.number<double>();
  read_text(fields, out);
  return out;
}

GnssFix read_fix(Fields& fields) {
  GnssFix out;
  out.t = fields.number<TimeNs>();
  out.type = GnssFixType(fields.up_to(int(GnssFixType::kFixed)));
  for (double* value : {&out.latitude_deg, &out.longitude_deg, &out.height_m,
                        &out.sigma_horizontal_m, &out.sigma_vertical_m}) {
    *value = fields.number<double>();
  }
  out.has_velocity = fields.up_to(1) != 0;
  for (int i = 0; i < 3; ++i) out.v_ned[i] = fields.number<double>();
  out.sigma_velocity_m_s = fields.number<double>();
  return out;
}

WheelSample read_wheel(Fields& fields) {
  WheelSample out;
  out.t = fields.number<TimeNs>();
  out.kind = WheelKind(fields.up_to(kWheelKinds - 1));
  for (double& value : out.value) value = fields.number<double>();
  return out;
}

bsp::GpioEdge read_edge(Fields& fields) {
  bsp::GpioEdge out;
  out.t = fields.number<TimeNs>();
  out.pin.bank = uint8_t(fields.up_to(UINT8_MAX));
  out.pin.line = uint8_t(fields.up_to(UINT8_MAX));
  out.level = fields.up_to(1) != 0;
  return out;
}

OrderRow read_row(Fields& fields) {
  OrderRow row;
  row.kind = ArrivalKind(fields.among(kOrderKinds));
  switch (row.kind) {
    case ArrivalKind::kImu:
      row.t = fields.number<TimeNs>();
      row.after_loss = fields.up_to(1) != 0;
      break;
    case ArrivalKind::kFrame:
      row.t = fields.number<TimeNs>();
      row.present = uint8_t(fields.up_to(3));
      for (TimeNs& late : row.late) late = fields.number<TimeNs>();
      row.lost_before = fields.number<uint32_t>();
      break;
    case ArrivalKind::kGnss:
      row.gnss = read_fix(fields);
      break;
    case ArrivalKind::kWheel:
      row.wheel = read_wheel(fields);
      break;
    case ArrivalKind::kEdge:
      row.edge = read_edge(fields);
      row.after_loss = fields.up_to(1) != 0;
      break;
    case ArrivalKind::kCommand:
      row.command = read_command(fields);
      break;
    case ArrivalKind::kFault:
      row.sensor = Sensor(fields.among(kSensorNames));
      row.status = fields.fault();
      break;
    case ArrivalKind::kLost:
    case ArrivalKind::kBack:
    case ArrivalKind::kEnd:
      row.sensor = Sensor(fields.among(kSensorNames));
      break;
    default:
      row.t = fields.number<TimeNs>();
  }
  return row;
}

// Calls read(fields) for each whole row.
template <class Read>
void read_rows(const std::string& path, const char* what, const char* what_to_do, Read&& read) {
  std::ifstream in(path);
  size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (in.eof()) break;  // no line end: cut off
    if (line.empty() || line[0] == '#') continue;
    Fields fields(line);
    read(fields);
    if (fields.ok()) continue;
    throw InputError(what, path + " line " + std::to_string(number), what_to_do);
  }
}

}  // namespace

std::vector<OrderRow> read_order(const std::string& path) {
  std::vector<OrderRow> out;
  read_rows(path, "order of arrivals: not a row",
            "repair the line, or remove the file: items then come by their stamps",
            [&](Fields& fields) { out.push_back(read_row(fields)); });
  return out;
}

std::vector<uint32_t> read_maps(const std::string& path) {
  std::vector<uint32_t> out;
  read_rows(path, "mapping's progress: not a row",
            "repair the line, or remove the file: mapping then goes at its own pace",
            [&](Fields& fields) {
              (void)fields.number<TimeNs>();
              out.push_back(fields.number<uint32_t>());
            });
  return out;
}

}  // namespace pirvs::tools
