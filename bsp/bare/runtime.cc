// What compiled C++ asks of its surroundings, where there is no C++ library: once-only statics,
// destructors that never run, failed asserts of the headers, and what a compiler calls of its own
// accord to fill and to copy: picolibc's work byte by byte, which took 9 % of a frame.
#include <atomic>
#include <cstdint>
#include <cstring>

#include "bsp/api/cores.h"
#include "bsp/bare/fault.h"
#include "core/base/assert.h"
#include "core/base/bytes.h"
#include "core/base/text.h"

namespace pirvs {

void assert_failed(const char* condition, const char* file, int line) {
  Text<256> what;
  what.put("bug: ").put(condition).put(" is false, ").put(file).put(':').number(line);
  bsp::fault_here(what.c_str());
}

}  // namespace pirvs

extern "C" {

void* memset(void* to, int value, size_t size) {
  pirvs::fill_bytes(to, static_cast<uint8_t>(value), size);
  return to;
}
void* memcpy(void* to, const void* from, size_t size) {
  pirvs::move_bytes(to, from, size);
  return to;
}
void* memmove(void* to, const void* from, size_t size) {
  pirvs::move_bytes(to, from, size);
  return to;
}

// Eigen's asserts, by glibc's header.
[[noreturn]] void __assert_fail(const char* condition, const char* file, unsigned line,
                                const char* function);
void __assert_fail(const char* condition, const char* file, unsigned line, const char*) {
  pirvs::assert_failed(condition, file, static_cast<int>(line));
}

[[noreturn]] void __cxa_pure_virtual();
void __cxa_pure_virtual() { pirvs::bsp::fault_here("bug: a pure virtual function was called"); }

[[noreturn]] void abort() noexcept;
void abort() noexcept { pirvs::bsp::fault_here("bug: abort"); }

// Static objects live until the power goes.
void* __dso_handle = nullptr;
int __cxa_atexit(void (*)(void*), void*, void*);
int __cxa_atexit(void (*)(void*), void*, void*) { return 0; }

// Itanium C++ ABI 3.3.2: byte 0 of the guard says "done"; we keep "begun" in byte 1.
int __cxa_guard_acquire(uint64_t* guard);
int __cxa_guard_acquire(uint64_t* guard) {
  auto* const done = reinterpret_cast<std::atomic<uint8_t>*>(guard);
  std::atomic<uint8_t>* const begun = done + 1;
  if (done->load(std::memory_order_acquire) != 0) return 0;
  if (begun->exchange(1, std::memory_order_acquire) == 0) return 1;
  while (done->load(std::memory_order_acquire) == 0) pirvs::bsp::relax();
  return 0;
}
void __cxa_guard_release(uint64_t* guard);
void __cxa_guard_release(uint64_t* guard) {
  reinterpret_cast<std::atomic<uint8_t>*>(guard)->store(1, std::memory_order_release);
}
void __cxa_guard_abort(uint64_t* guard);
void __cxa_guard_abort(uint64_t*) {}

}  // extern "C"
