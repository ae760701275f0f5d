// What    One message to a page: JSON, or JSON with an array behind it.
// In      The JSON, whose "type" says what it is; numbers or the bytes of an image.
// Out     Text frames are the JSON. Binary frames are uint32 the JSON's size, the JSON filled with
//         blanks to a multiple of four bytes, then the array. Little-endian.
// Errors  none.
// Source  docs/view.md, "Messages": the schema.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/time.h"
#include "core/math/types.h"

namespace pirvs::tools {

struct ViewMessage {
  // A page that is slow gets the newest of a lossy kind; of the others every one.
  enum class Kind : uint8_t { kLasting, kState, kFrame, kImageLeft, kImageRight, kLossyKinds };
  Kind kind = Kind::kLasting;
  bool binary = false;
  std::shared_ptr<const std::string> bytes;

  bool lossy() const { return kind != Kind::kLasting; }
};

ViewMessage view_message(const nlohmann::json& header,
                         ViewMessage::Kind kind = ViewMessage::Kind::kLasting);
ViewMessage view_message(const nlohmann::json& header, const void* array, size_t bytes,
                         ViewMessage::Kind kind = ViewMessage::Kind::kLasting);

// As few digits as say it: to a millionth. null: not finite.
nlohmann::json view_number(double value);
template <class Vector>
nlohmann::json view_numbers(const Vector& values) {
  nlohmann::json out = nlohmann::json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) out.push_back(view_number(double(values[i])));
  return out;
}
// Seconds to a microsecond.
nlohmann::json view_time(TimeNs t);

}  // namespace pirvs::tools
