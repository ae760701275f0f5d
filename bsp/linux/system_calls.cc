#include "bsp/linux/system_calls.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace pirvs::bsp {
namespace {

int open_node(const char* path) { return open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); }

int ioctl_again(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ioctl(fd, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

void* map_shared(size_t size, int fd, int64_t offset) {
  const int kind = fd < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED;
  void* const at = mmap(nullptr, size, PROT_READ | PROT_WRITE, kind, fd, offset);
  return at == MAP_FAILED ? nullptr : at;
}

}  // namespace

const SystemCalls kSystemCalls = {open_node, close, ioctl_again, map_shared, munmap};

}  // namespace pirvs::bsp
