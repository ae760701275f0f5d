#include "tools/dataset/text_table.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <utility>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_separator(char c) { return c == ',' || c == ';'; }

}  // namespace

TextTable::TextTable(const std::string& path, const std::string& what_it_is, const StampRule& rule)
    : path_(path), what_it_is_(what_it_is) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("cannot open the " + what_it_is, path, "check the path");
  std::ostringstream buffer;
  buffer << file.rdbuf();
  content_ = buffer.str();
  look_through(rule);
}

TextTable::TextTable(Content content, const std::string& path, const std::string& what_it_is,
                     const StampRule& rule)
    : path_(path), what_it_is_(what_it_is), content_(std::move(content.text)) {
  look_through(rule);
}

// The heading, and the first field of each line that is a number.
void TextTable::look_through(const StampRule& rule) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (content_.compare(0, kByteOrderMark.size(), kByteOrderMark) == 0) {
    content_.erase(0, kByteOrderMark.size());
  }
  std::string_view rest = content_;
  while (!rest.empty()) {
    std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    while (!line.empty() && (is_blank(line.front()) || line.front() == '#')) {
      if (line.front() == '#' && stamps_.empty()) heading_ = line.substr(1);
      if (line.front() == '#') break;
      line.remove_prefix(1);
    }
    const std::string_view field = line.substr(0, line.find_first_of(",; \t"));
    if (const auto number = stamp_number(field)) {
      any_point_ = any_point_ || field.find('.') != std::string_view::npos;
      stamps_.push_back(*number);
    } else if (stamps_.empty() && !line.empty() && line.front() != '#') {
      heading_ = line;
    }
  }
  while (!heading_.empty() && is_blank(heading_.front())) heading_.remove_prefix(1);
  settle_unit(rule);
}

void TextTable::settle_unit(const StampRule& rule) {
  unit_ = unit_of_stamps(stamps_, any_point_, heading_, rule);
}

bool TextTable::split(std::string_view line) {
  fields_.clear();
  has_commas_ = line.find_first_of(",;") != std::string_view::npos;
  size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && is_blank(line[at])) ++at;
    if (at == line.size()) break;
    size_t end = at;
    while (end < line.size() && !is_separator(line[end]) &&
           !(is_blank(line[end]) && !has_commas_)) {
      ++end;
    }
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
  if (!stamp_number(fields_[0])) return std::nullopt;
  if (unit_ == StampUnit::kUnknown) {
    fail("the stamps may be ns, us, ms or s", "give --stamps ns, us, ms or s");
  }
  return stamp_ns(fields_[0], unit_);
}

void TextTable::fail(const std::string& what, const std::string& what_to_do) const {
  throw InputError(what_it_is_ + ": " + what, path_ + " line " + std::to_string(line_), what_to_do);
}

}  // namespace pirvs::tools
