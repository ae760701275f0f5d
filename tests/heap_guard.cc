#include "tests/heap_guard.h"

#include <errno.h>
#include <execinfo.h>
#include <unistd.h>

#include <atomic>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* block, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace pirvs::systems {
namespace {

constexpr int kCallersMax = 24;

std::atomic<bool> armed{false};
std::atomic<size_t> count{0};
void* callers[kCallersMax];
int callers_size = 0;

void on_heap_call() {
  if (!armed.load(std::memory_order_relaxed)) return;
  if (count.fetch_add(1) == 0) callers_size = backtrace(callers, kCallersMax);
}

}  // namespace

HeapGuard::HeapGuard() {
  void* warm[2];
  backtrace(warm, 2);  // loads its library on first use
  count = 0;
  callers_size = 0;
  armed = true;
}

HeapGuard::~HeapGuard() { armed = false; }

size_t HeapGuard::calls() { return count; }

void HeapGuard::print_first() { backtrace_symbols_fd(callers, callers_size, STDERR_FILENO); }

}  // namespace pirvs::systems

extern "C" {

void* malloc(size_t size) {
  pirvs::systems::on_heap_call();
  return __libc_malloc(size);
}

void* calloc(size_t n, size_t size) {
  pirvs::systems::on_heap_call();
  return __libc_calloc(n, size);
}

void* realloc(void* block, size_t size) {
  pirvs::systems::on_heap_call();
  return __libc_realloc(block, size);
}

void* memalign(size_t alignment, size_t size) {
  pirvs::systems::on_heap_call();
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }

int posix_memalign(void** out, size_t alignment, size_t size) {
  *out = memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}

}  // extern "C"
