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
  const int kind = fields.number<int>();
  fields.check(kind >= 0 && kind < int(CommandKind::kCount));
  out.kind = CommandKind(kind);
  out.value = float(fields.number<double>());
  out.yaw_rad = fields.number<double>();
  for (int i = 0; i < 3; ++i) out.p_WB[i] = fields.number<double>();
  read_text(fields, out);
  return out;
}

OrderRow read_row(Fields& fields) {
  OrderRow row;
  row.kind = OrderKind(fields.among(kOrderKinds));
  switch (row.kind) {
    case OrderKind::kImu:
      row.t = fields.number<TimeNs>();
      row.after_loss = fields.number<int>() != 0;
      break;
    case OrderKind::kFrame:
      row.t = fields.number<TimeNs>();
      row.present = uint8_t(fields.number<int>() & 3);
      for (TimeNs& late : row.late) late = fields.number<TimeNs>();
      break;
    case OrderKind::kCommand:
      row.command = read_command(fields);
      break;
    case OrderKind::kFault:
      row.sensor = Sensor(fields.among(kSensorNames));
      row.status = fields.fault();
      break;
    case OrderKind::kEnd:
      row.sensor = Sensor(fields.among(kSensorNames));
      break;
    default:
      row.t = fields.number<TimeNs>();
  }
  return row;
}

}  // namespace

std::vector<OrderRow> read_order(const std::string& path) {
  std::ifstream in(path);
  std::vector<OrderRow> out;
  size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (in.eof()) break;  // no line end: cut off
    if (line.empty() || line[0] == '#') continue;
    Fields fields(line);
    out.push_back(read_row(fields));
    if (fields.ok()) continue;
    throw InputError("order of arrivals: not a row", path + " line " + std::to_string(number),
                     "repair the line, or remove the file: items then come by their stamps");
  }
  return out;
}

}  // namespace pirvs::tools
