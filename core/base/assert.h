// Stops on a bug of our own; on in release builds too.
// In      A condition that cannot be false unless the code is wrong. It must have no side effect.
// Out     Nothing, or never returns.
// Errors  A false condition calls assert_failed, which the linked bsp defines: Linux prints and
//         aborts, bare metal records file and line and restarts into a safe mode.
// Cost    One predicted branch.
// Source  STYLE principle 7.
#pragma once

namespace pirvs {

[[noreturn]] void assert_failed(const char* condition, const char* file, int line);

}  // namespace pirvs

#define PIRVS_ASSERT(condition)                      \
  (__builtin_expect(static_cast<bool>(condition), 1) \
       ? (void)0                                     \
       : ::pirvs::assert_failed(#condition, __FILE__, __LINE__))
