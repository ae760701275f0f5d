#include "core/config/key_values.h"

#include <cmath>

#include "core/base/number.h"

namespace pirvs {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

bool is_key_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

// substr() may throw: not without an operating system.
std::string_view part(std::string_view text, size_t from, size_t to) {
  return {text.data() + from, to - from};
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Text of any language, but no bytes that only a binary file has.
bool is_text(std::string_view line) {
  for (const char c : line) {
    const bool control = static_cast<unsigned char>(c) < ' ' && !is_blank(c);
    if (control || c == '\x7f') return false;
  }
  return true;
}

std::string_view without_comment(std::string_view line) {
  const size_t hash = line.find('#');
  return hash == std::string_view::npos ? line : part(line, 0, hash);
}

// The next line of a text from `at` on; at is then behind it.
std::string_view line_at(std::string_view text, size_t& at) {
  const size_t end = text.find('\n', at);
  const size_t stop = end == std::string_view::npos ? text.size() : end;
  const std::string_view line = part(text, at, stop);
  at = stop == text.size() ? stop : stop + 1;
  return line;
}

std::string_view key_of(std::string_view line) {
  const std::string_view said = without_comment(line);
  const size_t equals = said.find('=');
  return equals == std::string_view::npos ? std::string_view{} : trimmed(part(said, 0, equals));
}

bool has_key_before(std::string_view text, size_t end, std::string_view key) {
  for (size_t at = 0; at < end;) {
    if (key_of(line_at(text, at)) == key) return true;
  }
  return false;
}

}  // namespace

void put_fault(TextWriter& out, const char* file, const ConfigFault& fault) {
  out.put(file).put(':');
  if (fault.line > 0) out.number(fault.line).put(':');
  out.put(' ').put(fault.what);
  if (fault.key.empty()) return;
  out.put(": ");
  for (const char c : fault.key) out.put(static_cast<unsigned char>(c) < ' ' ? '?' : c);
}

KeyValues::KeyValues(std::string_view text) : text_(text) {
  if (part(text, 0, text.size() < 3 ? text.size() : 3) == kByteOrderMark) text_.remove_prefix(3);
}

bool KeyValues::fail(const char* what, std::string_view where) {
  constexpr size_t kShown = 60;
  fault_ = {line_, what, where.size() > kShown ? part(where, 0, kShown) : where};
  return false;
}

bool KeyValues::split(std::string_view text, KeyValue& out) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) return fail("not `key = value`", text);
  out.key = trimmed(part(text, 0, equals));
  out.value = trimmed(part(text, equals + 1, text.size()));
  out.line = line_;
  if (out.key.empty()) return fail("no key before `=`", text);
  for (const char c : out.key) {
    if (!is_key_letter(c)) return fail("a key has letters, digits, . _ - alone", out.key);
  }
  if (out.value.empty()) return fail("no value behind `=`", out.key);
  return true;
}

Status KeyValues::next(KeyValue& out) {
  if (fault_) return Status::kBadData;
  while (at_ < text_.size()) {
    const size_t begin = at_;
    const std::string_view line = line_at(text_, at_);
    ++line_;
    if (line.size() > kLineMax) (void)fail("a line longer than 512 bytes", {});
    if (!fault_ && !is_text(line)) (void)fail("bytes that are no text", {});
    if (fault_) return Status::kBadData;
    const std::string_view said = trimmed(without_comment(line));
    if (said.empty()) continue;
    if (!split(said, out)) return Status::kBadData;
    if (!has_key_before(text_, begin, out.key)) return Status::kOk;
    (void)fail("the key stands there twice", out.key);
    return Status::kBadData;
  }
  return Status::kStale;
}

std::string_view behind(std::string_view text, std::string_view prefix) {
  if (text.size() <= prefix.size() || part(text, 0, prefix.size()) != prefix) return {};
  return part(text, prefix.size(), text.size());
}

bool read_words(std::string_view value, std::string_view* out, int count) {
  int found = 0;
  const auto parts = [](char c) { return is_blank(c) || c == ','; };
  for (size_t at = 0; at < value.size();) {
    if (parts(value[at])) {
      ++at;
      continue;
    }
    size_t end = at;
    while (end < value.size() && !parts(value[end])) ++end;
    if (found == count) return false;
    out[found++] = part(value, at, end);
    at = end;
  }
  return found == count;
}

bool read_numbers(std::string_view value, double* out, int count) {
  constexpr int kNumbersMax = 16;
  std::string_view words[kNumbersMax];
  double numbers[kNumbersMax];
  if (count > kNumbersMax || !read_words(value, words, count)) return false;
  for (int i = 0; i < count; ++i) {
    if (!read_number(words[i], numbers[i]) || !std::isfinite(numbers[i])) return false;
  }
  for (int i = 0; i < count; ++i) out[i] = numbers[i];
  return true;
}

bool read_whole(std::string_view value, int64_t min, int64_t max, int64_t& out) {
  constexpr double kExact = 9e15;  // whole numbers below are doubles
  double number = 0;
  if (!read_number(value, number) || !(number > -kExact && number < kExact)) return false;
  const auto whole = static_cast<int64_t>(number);
  if (static_cast<double>(whole) != number || whole < min || whole > max) return false;
  out = whole;
  return true;
}

bool read_yes_no(std::string_view value, bool& out) {
  if (value != "yes" && value != "no") return false;
  out = value == "yes";
  return true;
}

}  // namespace pirvs
