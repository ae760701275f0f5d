// What    Reads text tables of numbers (ASL .csv, TUM .tum) and points at the line that is wrong.
// In      A file of rows; fields apart by commas, semicolons or blanks; '#' starts a comment line.
// Out     One row at a time: its fields as text, its line number; decoded on request.
// Units   stamps, in the first column: one unit for the whole column (stamps.h); all become TimeNs
//         exactly.
// Errors  InputError with file and line; of stamps whose unit nothing tells, too. A last line that
//         was cut off is not an error: cut_off().
// Cost    ~0.3 us per field; an EuRoC recording's IMU loads in ~50 ms.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/dataset/stamps.h"

namespace pirvs::tools {

class TextTable {
 public:
  // Reads the whole file. what_it_is names it in error messages ("IMU samples").
  TextTable(const std::string& path, const std::string& what_it_is, const StampRule& rule = {});

  // Of a text that is no file; `path` is what errors name.
  struct Content {
    std::string text;
  };
  TextTable(Content content, const std::string& path, const std::string& what_it_is,
            const StampRule& rule = {});
  // Rows and headings point into the text.
  TextTable(const TextTable&) = delete;
  TextTable& operator=(const TextTable&) = delete;

  // Steps to the next row; false at the end. The first row may be a heading and is then skipped.
  bool next();

  size_t columns() const { return fields_.size(); }
  std::string_view text(size_t column) const { return fields_[column]; }
  std::optional<double> number(size_t column) const;  // may be NaN; nullopt: not a number
  std::optional<TimeNs> stamp() const;                // of the first column
  bool has_commas() const { return has_commas_; }
  StampUnit unit() const { return unit_; }
  // Once more, where something is known that was not when the table was opened.
  void settle_unit(const StampRule& rule);
  size_t line() const { return line_; }
  // The last line above the first row that is not one, without its '#'; perhaps empty.
  std::string_view heading() const { return heading_; }
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
  std::vector<std::string_view> fields_;
  std::string_view heading_;
  std::vector<double> stamps_;  // rows' first fields
  bool any_point_ = false;
  StampUnit unit_ = StampUnit::kUnknown;

  void look_through(const StampRule& rule);
  bool split(std::string_view line);
};

}  // namespace pirvs::tools
