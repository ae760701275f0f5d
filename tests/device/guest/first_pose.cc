// Waits for the first pose that pirvsd sends to this machine, and says when it came.
// usage: first_pose PORT
// Out     "first pose P s after power, K s after the kernel's start: LINE". Power is when the
//         processor's counter was zero.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <time.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<uint16_t>(argc > 1 ? std::atoi(argv[1]) : 0));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (bind(fd, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) {
    std::perror("bind");
    return 1;
  }
  char line[512];
  const ssize_t size = recv(fd, line, sizeof line - 1, 0);
  if (size <= 0) return 1;
  line[size] = 0;
  uint64_t count = 0, rate_hz = 0;
  asm volatile("mrs %0, cntvct_el0" : "=r"(count));
  asm volatile("mrs %0, cntfrq_el0" : "=r"(rate_hz));
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  std::printf("first pose %.2f s after power, %.2f s after the kernel's start: %s",
              static_cast<double>(count) / static_cast<double>(rate_hz),
              static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec), line);
  return 0;
}
