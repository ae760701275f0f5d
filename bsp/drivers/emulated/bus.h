// The bus of a test: bsp/api/mmio.h answered by emulated chips instead of memory.
// In      Attachment(base, chip): as long as it lives, addresses base .. base + T::kSize go to
//         chip.read(offset) and chip.write(offset, value). At most kChipsMax at a time.
// Out     What the chip makes of the access. Linked on hosts only.
// Errors  An address where no chip is, or that is not a multiple of 4, is a bug of the driver and
//         asserts, as it would end in a fault report on hardware. Overlapping chips assert, too.
// Cost    A search through at most kChipsMax ranges. One thread.
// Source  Zephyr's drivers on emulated buses; STYLE principle 13.
#pragma once

#include <cstdint>

namespace pirvs::bsp::emulated {

inline constexpr int kChipsMax = 8;

struct Chip {
  uintptr_t base = 0;
  uint32_t size = 0;  // 0: free
  void* self = nullptr;
  uint32_t (*read)(void* self, uint32_t offset) = nullptr;
  void (*write)(void* self, uint32_t offset, uint32_t value) = nullptr;
};

class Attachment {
 public:
  template <class T>
  Attachment(uintptr_t base, T& chip)
      : slot_(
            attach({base, T::kSize, &chip,
                    [](void* self, uint32_t offset) { return static_cast<T*>(self)->read(offset); },
                    [](void* self, uint32_t offset, uint32_t value) {
                      static_cast<T*>(self)->write(offset, value);
                    }})) {}
  ~Attachment() { detach(slot_); }
  Attachment(const Attachment&) = delete;
  Attachment& operator=(const Attachment&) = delete;

 private:
  static int attach(const Chip& chip);
  static void detach(int slot);

  int slot_;
};

}  // namespace pirvs::bsp::emulated
