// What    Reads text tables of numbers (ASL .csv, TUM .tum) and points at the line that is wrong.
// In      A file of rows; fields apart by commas or blanks; '#' starts a comment line.
// Out     One row at a time: its fields as text, its line number; decoded on request.
// Units   stamps: integer nanoseconds, or seconds with a decimal point; both become TimeNs exactly.
//         Short integers are seconds, unless a heading says `[ns]`, as ASL's do: a device's clock
//         counts from its start.
// Errors  InputError with file and line. A last line that was cut off is not an error: truncated().
// Cost    ~0.3 us per field; an EuRoC recording's IMU loads in ~50 ms.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace pirvs::tools {

class TextTable {
 public:
  // Reads the whole file. what_it_is names it in error messages ("IMU samples").
  TextTable(const std::string& path, const std::string& what_it_is);

  // Steps to the next row; false at the end. The first row may be a heading and is then skipped.
  bool next();

  size_t columns() const { return fields_.size(); }
  std::string_view text(size_t column) const { return fields_[column]; }
  std::optional<double> number(size_t column) const;  // may be NaN; nullopt: not a number
  std::optional<TimeNs> stamp(size_t column) const;
  bool has_commas() const { return has_commas_; }
  // The row at hand is the file's last one and has no line end: it may have been cut off.
  bool cut_off() const { return cut_off_; }

  // Throws InputError about the row at hand.
  [[noreturn]] void fail(const std::string& what, const std::string& what_to_do) const;

 private:
  std::string path_;
  std::string what_it_is_;
  std::string content_;
  size_t offset_ = 0;
  size_t line_ = 0;
  size_t rows_ = 0;
  bool has_commas_ = false;
  bool cut_off_ = false;
  bool whole_is_ns_ = false;
  std::vector<std::string_view> fields_;

  bool split(std::string_view line);
};

// Integer nanoseconds ("1403636584763555584") or decimal seconds ("1403636584.763555584").
std::optional<TimeNs> parse_stamp(std::string_view text, bool whole_is_ns = false);

}  // namespace pirvs::tools
