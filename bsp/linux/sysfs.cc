#include "bsp/linux/sysfs.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>

namespace pirvs::bsp {

bool read_file(const char* path, char* out, size_t max) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const ssize_t got = read(fd, out, max - 1);
  close(fd);
  out[got > 0 ? got : 0] = 0;
  return got >= 0;
}

bool read_line(const char* path, char* out, size_t max) {
  if (!read_file(path, out, max)) return false;
  char* const end = std::strchr(out, '\n');
  if (end != nullptr) *end = 0;
  return true;
}

bool write_file(const char* path, const char* text) {
  const int fd = open(path, O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (fd < 0) return false;
  const auto size = static_cast<ssize_t>(std::strlen(text));
  const bool written = write(fd, text, static_cast<size_t>(size)) == size;
  return close(fd) == 0 && written;
}

std::string_view value_of(std::string_view lines, std::string_view key) {
  size_t at = 0;
  while (at < lines.size()) {
    size_t end = at;
    while (end < lines.size() && lines[end] != '\n') ++end;
    const std::string_view line(lines.data() + at, end - at);
    const bool found = line.size() > key.size() && line[key.size()] == '=' &&
                       std::memcmp(line.data(), key.data(), key.size()) == 0;
    if (found) return {line.data() + key.size() + 1, line.size() - key.size() - 1};
    at = end + 1;
  }
  return {};
}

}  // namespace pirvs::bsp
