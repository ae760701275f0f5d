#include "bsp/linux/text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

#include <cstring>

namespace pirvs::bsp {

const char* read_text_file(const char* path, char* out, size_t max, std::string_view& text) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return std::strerror(errno);
  size_t size = 0;
  ssize_t got = 0;
  while (size < max && (got = read(fd, out + size, max - size)) > 0) {
    size += static_cast<size_t>(got);
  }
  const int error = errno;
  close(fd);
  if (got < 0) return std::strerror(error);
  if (size == max) return "the file is too large";
  out[size] = 0;
  text = {out, size};
  return nullptr;
}

}  // namespace pirvs::bsp
