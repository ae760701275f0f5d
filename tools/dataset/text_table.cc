#include "tools/dataset/text_table.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr size_t kShort =
    15;  // digits of a time in seconds are never more, since 1970 in ns are 19

std::optional<int64_t> whole_number(std::string_view text) {
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size();
  return good ? std::optional(value) : std::nullopt;
}

// The first field of each line that is a number, as text.
template <class Visit>
void for_each_stamp(std::string_view content, Visit&& visit) {
  while (!content.empty()) {
    std::string_view line = content.substr(0, content.find('\n'));
    content.remove_prefix(std::min(line.size() + 1, content.size()));
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    const std::string_view field = line.substr(0, line.find_first_of(", \t\r"));
    if (whole_number(field.substr(0, field.find('.')))) visit(field);
  }
}

StampUnit unit_by_spacing(std::vector<int64_t>& stamps) {
  constexpr uint64_t kSecondsMax = 1000, kNanosecondsMin = 100'000;
  constexpr int64_t kLatest_s = 20'000'000'000;  // nobody's clock shows the year 2603
  bool late = false;
  std::vector<uint64_t> steps;
  for (size_t i = 0; i < stamps.size(); ++i) {
    late = late || stamps[i] > kLatest_s || stamps[i] < -kLatest_s;
    const int64_t before = stamps[i > 0 ? i - 1 : 0];  // 15 digits: no difference overflows
    if (stamps[i] != before) steps.push_back(uint64_t(std::abs(stamps[i] - before)));
  }
  if (steps.empty()) return late ? StampUnit::kNanoseconds : StampUnit::kUnknown;
  const auto middle = steps.begin() + std::ptrdiff_t(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (*middle >= kNanosecondsMin) return StampUnit::kNanoseconds;
  return *middle <= kSecondsMax && !late ? StampUnit::kSeconds : StampUnit::kUnknown;
}

StampUnit unit_of_stamps(std::string_view content) {
  // As the heading of an ASL table says.
  if (content.substr(0, content.find('\n')).find("[ns]") != std::string_view::npos) {
    return StampUnit::kNanoseconds;
  }
  bool any_long = false, any_point = false;
  std::vector<int64_t> stamps;
  for_each_stamp(content, [&](std::string_view field) {
    const size_t point = field.find('.');
    any_point = any_point || point != std::string_view::npos;
    any_long = any_long || (point == std::string_view::npos && field.size() > kShort);
    if (!any_point && !any_long) stamps.push_back(*whole_number(field));
  });
  if (any_long) return StampUnit::kNanoseconds;
  return any_point ? StampUnit::kSeconds : unit_by_spacing(stamps);
}

std::optional<TimeNs> decimal_seconds(std::string_view text) {
  const size_t point = text.find('.');
  const std::optional<int64_t> whole = whole_number(text.substr(0, point));
  if (!whole || *whole > INT64_MAX / kSecond_ns || *whole < INT64_MIN / kSecond_ns) {
    return std::nullopt;
  }
  const TimeNs value = *whole * kSecond_ns;
  if (point == std::string_view::npos) return value;
  TimeNs weight = kSecond_ns / 10;
  TimeNs fraction = 0;
  for (const char c : text.substr(point + 1)) {
    if (!is_digit(c)) return std::nullopt;
    fraction += weight * (c - '0');  // digits below 1 ns have weight 0
    weight /= 10;
  }
  return text[0] == '-' ? value - fraction : value + fraction;
}

}  // namespace

TextTable::TextTable(const std::string& path, const std::string& what_it_is)
    : path_(path), what_it_is_(what_it_is) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("cannot open the " + what_it_is, path, "check the path");
  std::ostringstream buffer;
  buffer << file.rdbuf();
  content_ = buffer.str();
  unit_ = unit_of_stamps(content_);
}

bool TextTable::split(std::string_view line) {
  fields_.clear();
  has_commas_ = line.find(',') != std::string_view::npos;
  size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && is_blank(line[at])) ++at;
    if (at == line.size()) break;
    size_t end = at;
    while (end < line.size() && line[end] != ',' && !(is_blank(line[end]) && !has_commas_)) ++end;
    size_t last = end;
    while (last > at && is_blank(line[last - 1])) --last;
    fields_.push_back(line.substr(at, last - at));
    at = end < line.size() ? end + 1 : end;
  }
  return !fields_.empty();
}

bool TextTable::next() {
  while (offset_ < content_.size()) {
    const size_t end = content_.find('\n', offset_);
    cut_off_ = end == std::string::npos;
    const size_t size = (cut_off_ ? content_.size() : end) - offset_;
    const std::string_view line(content_.data() + offset_, size);
    offset_ += size + 1;
    ++line_;
    if (line.empty() || line[0] == '#' || !split(line)) continue;
    const bool heading = rows_++ == 0 && !number(0);
    if (!heading) return true;
  }
  return false;
}

std::optional<double> TextTable::number(size_t column) const {
  if (column >= fields_.size()) return std::nullopt;
  std::string_view field = fields_[column];
  if (!field.empty() && field[0] == '+') field.remove_prefix(1);
  double value = 0;
  const char* const last = field.data() + field.size();
  const auto [end, error] = std::from_chars(field.data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

std::optional<TimeNs> TextTable::stamp() const {
  const std::string_view field = fields_[0];
  if (field.find('.') != std::string_view::npos) return decimal_seconds(field);
  const std::optional<int64_t> value = whole_number(field);
  if (!value) return std::nullopt;
  if (unit_ == StampUnit::kUnknown) {
    fail("the stamps may be nanoseconds or seconds",
         "write seconds with a decimal point, nanoseconds with 16 digits or more");
  }
  return unit_ == StampUnit::kSeconds ? decimal_seconds(field) : value;
}

void TextTable::fail(const std::string& what, const std::string& what_to_do) const {
  throw InputError(what_it_is_ + ": " + what, path_ + " line " + std::to_string(line_), what_to_do);
}

}  // namespace pirvs::tools
