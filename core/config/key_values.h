// Settings as plain text: `key = value`, one a line; what follows a # is a comment.
// In      The text, which must outlive what is read from it. Windows' line ends and byte order mark
//         are fine.
// Out     next(): the lines that say something, in order, each a view into the text. read_words,
//         read_numbers, read_whole, read_yes_no: a value as more than text.
// Errors  kStale: the end. kBadData: fault() says the line and what is wrong with it: no `=`, no
//         key, no value, a key twice, letters that a key cannot have, a line too long, bytes that
//         are no text. The readers: false, and nothing changes.
// Cost    Looks for each key in all lines before it: for start-up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/status.h"
#include "core/base/text.h"

namespace pirvs {

struct KeyValue {
  int line = 0;  // from 1
  std::string_view key, value;
};

// What is wrong with a text of settings, for its writer. line 0: with all of it.
struct ConfigFault {
  int line = 0;
  const char* what = nullptr;
  std::string_view key;  // or the line itself, where it has none

  explicit operator bool() const { return what != nullptr; }
};

// `file:line: what: key`.
void put_fault(TextWriter& out, const char* file, const ConfigFault& fault);

class KeyValues {
 public:
  static constexpr size_t kLineMax = 512;

  explicit KeyValues(std::string_view text);

  Status next(KeyValue& out);
  const ConfigFault& fault() const { return fault_; }

 private:
  bool split(std::string_view text, KeyValue& out);
  bool fail(const char* what, std::string_view where);

  std::string_view text_;
  size_t at_ = 0;
  int line_ = 0;
  ConfigFault fault_;
};

// What stands behind a prefix; empty: nothing does, or the text begins otherwise.
std::string_view behind(std::string_view text, std::string_view prefix);

// Words parted by blanks or commas; false: there are not exactly so many.
[[nodiscard]] bool read_words(std::string_view value, std::string_view* out, int count);
[[nodiscard]] bool read_numbers(std::string_view value, double* out, int count);
[[nodiscard]] bool read_whole(std::string_view value, int64_t min, int64_t max, int64_t& out);
[[nodiscard]] bool read_yes_no(std::string_view value, bool& out);

}  // namespace pirvs
