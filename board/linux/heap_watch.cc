#include "board/linux/heap_watch.h"

#include <cstddef>

#include "core/base/counter.h"

namespace {

pirvs::Counter all, at_start;

}  // namespace

extern "C" {

void* __real_malloc(size_t size);
void* __real_calloc(size_t count, size_t size);
void* __real_realloc(void* old, size_t size);

void* __wrap_malloc(size_t size) {
  ++all;
  return __real_malloc(size);
}

void* __wrap_calloc(size_t count, size_t size) {
  ++all;
  return __real_calloc(count, size);
}

void* __wrap_realloc(void* old, size_t size) {
  ++all;
  return __real_realloc(old, size);
}

}  // extern "C"

namespace pirvs::board::heap {

void start_is_over() { at_start = all; }
uint32_t calls() { return all; }
uint32_t calls_after_start() { return all - at_start; }

}  // namespace pirvs::board::heap
