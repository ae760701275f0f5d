#include "tools/view/message.h"

#include <cmath>

namespace pirvs::tools {

using nlohmann::json;

namespace {

// Text that is no UTF-8 comes from files and devices: it is shown as well as it can be.
std::string dump(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

ViewMessage view_message(const json& header, ViewMessage::Kind kind) {
  return {kind, false, std::make_shared<const std::string>(dump(header))};
}

ViewMessage view_message(const json& header, const void* array, size_t bytes,
                         ViewMessage::Kind kind) {
  std::string text = dump(header);
  constexpr size_t kWord = 4;
  while (text.size() % kWord != 0) text += ' ';
  const auto size = static_cast<uint32_t>(text.size());
  std::string out(reinterpret_cast<const char*>(&size), sizeof size);
  out.reserve(out.size() + text.size() + bytes);
  out += text;
  if (bytes > 0) out.append(static_cast<const char*>(array), bytes);
  return {kind, true, std::make_shared<const std::string>(std::move(out))};
}

json view_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  constexpr double kDigits = 1e6;
  const double scaled = std::round(value * kDigits);
  return std::fabs(scaled) < 9e15 ? scaled / kDigits : value;
}

json view_time(TimeNs t) { return static_cast<double>(t / 1000) / 1e6; }

}  // namespace pirvs::tools
