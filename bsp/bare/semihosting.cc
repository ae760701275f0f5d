#include "bsp/bare/semihosting.h"

#include <cstring>

namespace pirvs::bsp {
namespace {

enum Operation : uint64_t {
  kOpen = 0x01,
  kClose = 0x02,
  kWrite = 0x05,
  kRead = 0x06,
  kSize = 0x0c,
  kRemove = 0x0e,
  kRename = 0x0f,
  kExit = 0x18
};
constexpr uint64_t kReadBinary = 1;             // mode "rb"
constexpr uint64_t kWriteBinary = 5;            // mode "wb"
constexpr uint64_t kApplicationExit = 0x20026;  // ADP_Stopped_ApplicationExit

int64_t ask(Operation operation, const uint64_t* block) {
  register uint64_t x0 asm("x0") = operation;
  register const uint64_t* x1 asm("x1") = block;
  asm volatile("hlt #0xf000" : "+r"(x0) : "r"(x1) : "memory");
  return static_cast<int64_t>(x0);
}

uint64_t number(const void* pointer) { return reinterpret_cast<uint64_t>(pointer); }

int64_t open(const char* path, uint64_t mode) {
  const uint64_t block[] = {number(path), mode, std::strlen(path)};
  return ask(kOpen, block);
}

}  // namespace

int64_t semihosting_open(const char* path) { return open(path, kWriteBinary); }

int64_t semihosting_open_to_read(const char* path) { return open(path, kReadBinary); }

bool semihosting_write(int64_t handle, const void* data, size_t size) {
  const uint64_t block[] = {static_cast<uint64_t>(handle), number(data), size};
  return ask(kWrite, block) == 0;  // the answer: how much was not written
}

size_t semihosting_read(int64_t handle, void* data, size_t max) {
  const uint64_t block[] = {static_cast<uint64_t>(handle), number(data), max};
  const int64_t left = ask(kRead, block);  // the answer: how much was not read
  return left >= 0 && static_cast<size_t>(left) <= max ? max - static_cast<size_t>(left) : 0;
}

int64_t semihosting_size(int64_t handle) {
  const uint64_t block[] = {static_cast<uint64_t>(handle)};
  return ask(kSize, block);
}

bool semihosting_rename(const char* from, const char* to) {
  const uint64_t block[] = {number(from), std::strlen(from), number(to), std::strlen(to)};
  return ask(kRename, block) == 0;
}

bool semihosting_remove(const char* path) {
  const uint64_t block[] = {number(path), std::strlen(path)};
  return ask(kRemove, block) == 0;
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
