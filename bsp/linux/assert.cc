#include "core/base/assert.h"

#include <cstdio>
#include <cstdlib>

namespace pirvs {

void assert_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: bug: %s is false\n", file, line, condition);
  std::abort();
}

}  // namespace pirvs
