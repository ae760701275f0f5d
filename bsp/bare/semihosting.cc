#include "bsp/bare/semihosting.h"

#include <cstring>

namespace pirvs::bsp {
namespace {

enum Operation : uint64_t { kOpen = 0x01, kClose = 0x02, kWrite = 0x05, kExit = 0x18 };
constexpr uint64_t kWriteBinary = 5;            // mode "wb"
constexpr uint64_t kApplicationExit = 0x20026;  // ADP_Stopped_ApplicationExit

int64_t ask(Operation operation, const uint64_t* block) {
  register uint64_t x0 asm("x0") = operation;
  register const uint64_t* x1 asm("x1") = block;
  asm volatile("hlt #0xf000" : "+r"(x0) : "r"(x1) : "memory");
  return static_cast<int64_t>(x0);
}

}  // namespace

int64_t semihosting_open(const char* path) {
  const uint64_t block[] = {reinterpret_cast<uint64_t>(path), kWriteBinary, std::strlen(path)};
  return ask(kOpen, block);
}

bool semihosting_write(int64_t handle, const void* data, size_t size) {
  const uint64_t block[] = {static_cast<uint64_t>(handle), reinterpret_cast<uint64_t>(data), size};
  return ask(kWrite, block) == 0;  // the answer: how much was not written
}

bool semihosting_close(int64_t handle) {
  const uint64_t block[] = {static_cast<uint64_t>(handle)};
  return ask(kClose, block) == 0;
}

void semihosting_exit(int code) {
  const uint64_t block[] = {kApplicationExit, static_cast<uint64_t>(code)};
  for (;;) ask(kExit, block);
}

}  // namespace pirvs::bsp
