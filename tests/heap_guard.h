// Counts heap calls of this process while armed: malloc, calloc, realloc, the aligned ones, and so
// operator new. The linker takes the guard's malloc before the C library's, which does the work.
// In      HeapGuard lives: armed, for every thread.
// Out     calls(); print_first(): who called first, as addresses that addr2line understands.
// Errors  One guard at a time.
// Cost    one load per heap call when not armed.
// Source  glibc manual, "Replacing malloc".
#pragma once

#include <cstddef>

namespace pirvs::systems {

class HeapGuard {
 public:
  HeapGuard();
  ~HeapGuard();
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;

  static size_t calls();  // since the last guard began
  static void print_first();
};

}  // namespace pirvs::systems
