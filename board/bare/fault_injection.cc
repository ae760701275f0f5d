#include "board/bare/fault_injection.h"

#include <cstring>

#include "bsp/api/cores.h"
#include "bsp/bare/boot.h"
#include "core/base/assert.h"

namespace pirvs::board {
namespace {

constexpr uint32_t kFrameDefault = 20;

[[gnu::noinline]] uint64_t read_null() {
  const uint64_t* null = nullptr;
  uint64_t value;
  asm volatile("ldr %0, [%1, #16]" : "=r"(value) : "r"(null));
  return value;
}

// Each call takes a kilobyte. The end that it never reaches is read from memory, so that a compiler
// neither warns of the recursion nor turns it into a loop.
volatile uint64_t no_end = UINT64_MAX;
[[gnu::noinline]] uint64_t descend(uint64_t depth) {  // NOLINT(misc-no-recursion): it is the fault
  volatile uint64_t block[128];
  block[depth % 128] = depth;
  if (depth == no_end) return block[0];
  return descend(depth + 1) + block[(depth + 1) % 128];
}

[[gnu::noinline]] void never_return() {
  for (;;) asm volatile("");
}

uint32_t number_of(const char* text) {
  uint32_t value = 0;
  for (; *text >= '0' && *text <= '9'; ++text)
    value = 10 * value + static_cast<uint32_t>(*text - '0');
  return value;
}

}  // namespace

bool FaultInjection::configure() {
  static constexpr struct {
    const char* name;
    Kind kind;
  } kKinds[] = {{"null", Kind::kNull},
                {"stack", Kind::kStack},
                {"hang", Kind::kHang},
                {"assert", Kind::kAssert}};
  char text[16];
  if (!bsp::boot_argument("fault", text, sizeof text)) return true;
  for (const auto& row : kKinds) {
    if (std::strcmp(text, row.name) == 0) kind_ = row.kind;
  }
  at_ = kFrameDefault;
  if (bsp::boot_argument("fault_at", text, sizeof text)) at_ = number_of(text);
  if (bsp::boot_argument("fault_core", text, sizeof text)) core_ = number_of(text);
  return kind_ != Kind::kNone;
}

void FaultInjection::begin() const {
  if (core_ == 0) return strike();
  const auto entry = [](void* self) { static_cast<FaultInjection*>(self)->strike(); };
  const Status started =
      bsp::start_core(static_cast<int>(core_), entry, const_cast<FaultInjection*>(this));
  PIRVS_ASSERT(started == Status::kOk);
  for (;;) bsp::relax();
}

void FaultInjection::strike() const {
  switch (kind_) {
    case Kind::kNull:
      (void)read_null();
      break;
    case Kind::kStack:
      (void)descend(0);
      break;
    case Kind::kHang:
      never_return();
      break;
    case Kind::kAssert: {
      const bool this_is_a_test = false;
      PIRVS_ASSERT(this_is_a_test);
      break;
    }
    case Kind::kNone:
      break;
  }
}

}  // namespace pirvs::board
