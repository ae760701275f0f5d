#include "bsp/linux/tty.h"

#include <fcntl.h>
#include <termios.h>

#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

struct Speed {
  int64_t baud;
  speed_t code;
};
constexpr Speed kSpeeds[] = {
    {9'600, B9600},        {19'200, B19200},      {38'400, B38400},      {57'600, B57600},
    {115'200, B115200},    {230'400, B230400},    {460'800, B460800},    {500'000, B500000},
    {576'000, B576000},    {921'600, B921600},    {1'000'000, B1000000}, {1'500'000, B1500000},
    {2'000'000, B2000000}, {3'000'000, B3000000}, {4'000'000, B4000000},
};

const Speed* find_speed(int64_t baud) {
  for (const Speed& speed : kSpeeds) {
    if (speed.baud == baud) return &speed;
  }
  return nullptr;
}

}  // namespace

bool is_baud(int64_t baud) { return find_speed(baud) != nullptr; }

int tty_open(const char* path, int baud) {
  PIRVS_ASSERT(baud == 0 || is_baud(baud));
  const int fd = ::open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return -1;
  termios line{};
  if (tcgetattr(fd, &line) != 0) return fd;
  cfmakeraw(&line);
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  line.c_cflag |= CLOCAL;
  if (baud != 0) (void)cfsetspeed(&line, find_speed(baud)->code);
  (void)tcsetattr(fd, TCSANOW, &line);
  return fd;
}

}  // namespace pirvs::bsp
