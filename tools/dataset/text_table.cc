#include "tools/dataset/text_table.h"

#include <charconv>
#include <fstream>
#include <sstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::optional<TimeNs> parse_stamp(std::string_view text, bool whole_is_ns) {
  const size_t point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  TimeNs value = 0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error != std::errc() || end != whole.data() + whole.size()) return std::nullopt;
  // As everybody's tools do: a short integer is a time in seconds, a long one in nanoseconds.
  if (point == std::string_view::npos && (whole_is_ns || whole.size() > 15)) return value;
  constexpr TimeNs kSecond = 1'000'000'000;
  if (value > INT64_MAX / kSecond || value < INT64_MIN / kSecond) return std::nullopt;
  value *= kSecond;
  if (point == std::string_view::npos) return value;
  TimeNs weight = kSecond / 10;
  TimeNs fraction = 0;
  for (const char c : text.substr(point + 1)) {
    if (!is_digit(c)) return std::nullopt;
    fraction += weight * (c - '0');  // digits below 1 ns have weight 0
    weight /= 10;
  }
  return text[0] == '-' ? value - fraction : value + fraction;
}

TextTable::TextTable(const std::string& path, const std::string& what_it_is)
    : path_(path), what_it_is_(what_it_is) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("cannot open the " + what_it_is, path, "check the path");
  std::ostringstream buffer;
  buffer << file.rdbuf();
  content_ = buffer.str();
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
    if (line.find("[ns]") != std::string_view::npos) whole_is_ns_ = true;
    if (line.empty() || line[0] == '#' || !split(line)) continue;
    const bool heading = rows_++ == 0 && !number(0) && !stamp(0);
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

std::optional<TimeNs> TextTable::stamp(size_t column) const {
  return column < fields_.size() ? parse_stamp(fields_[column], whole_is_ns_) : std::nullopt;
}

void TextTable::fail(const std::string& what, const std::string& what_to_do) const {
  throw InputError(what_it_is_ + ": " + what, path_ + " line " + std::to_string(line_), what_to_do);
}

}  // namespace pirvs::tools
