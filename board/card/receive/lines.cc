#include "board/card/receive/lines.h"

namespace pirvs::card {
namespace {

bool take(std::string_view& text, std::string_view start) {
  if (text.substr(0, start.size()) != start) return false;
  text.remove_prefix(start.size());
  return true;
}

// Digits alone, 18 at most.
bool read_digits(std::string_view text, uint64_t& value) {
  constexpr size_t kDigitsMax = 18;
  if (text.empty() || text.size() > kDigitsMax) return false;
  value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return false;
    value = value * 10 + static_cast<uint64_t>(c - '0');
  }
  return true;
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

}  // namespace

Request parse_request(std::string_view line) {
  Request out;
  line = trim(line);
  if (!take(line, "pirvs 1 ")) return out;
  if (line == "version") out.kind = Request::Kind::kVersion;
  if (take(line, "update ") && read_digits(line, out.bytes) && out.bytes > 0 &&
      out.bytes <= kBundleBytesMax) {
    out.kind = Request::Kind::kUpdate;
  }
  return out;
}

RaucLine parse_rauc(std::string_view line) {
  RaucLine out;
  line = trim(line);
  if (take(line, "LastError: ")) {
    out.kind = RaucLine::Kind::kError;
    out.text = trim(line);
    return out;
  }
  constexpr uint64_t kAll = 100;
  const size_t sign = line.find("% ");
  uint64_t percent = 0;
  if (sign == std::string_view::npos || !read_digits(line.substr(0, sign), percent) ||
      percent > kAll) {
    return out;
  }
  out.kind = RaucLine::Kind::kProgress;
  out.percent = static_cast<int>(percent);
  out.text = trim(line.substr(sign + 2));
  return out;
}

std::string_view find_value(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!take(line, key) || !take(line, "=")) continue;
    if (line.size() >= 2 && line.front() == '"' && line.back() == '"') {
      line = line.substr(1, line.size() - 2);
    }
    return line;
  }
  return {};
}

std::string_view find_word(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const size_t end = text.find_first_of(" \n");
    std::string_view word = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (take(word, key) && take(word, "=")) return word;
  }
  return {};
}

}  // namespace pirvs::card
