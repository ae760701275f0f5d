// Which of the card's two slots, a and b, U-Boot starts: one state in two raw sectors.
// In      The two sectors, as read.
// Out     read_state: that of the first sector if it is whole, else of the second, else slot a is
//         good. put_state: a sector to be written to both places, the first one first.
// Errors  None: a torn sector is passed over, and from() says so.
// Cost    microseconds.
// Source  U-Boot's `env export -c`: CRC-32 of the rest, little-endian, then `key=value`, each with
//         a zero, and another zero. board/ironsides/image/boot.cmd reads and writes the same.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::card {

inline constexpr size_t kSectorBytes = 512;
// An erase block of 4 MiB for each: what tears one sector leaves the other alone.
inline constexpr uint64_t kStateSectors[2] = {0x2000, 0x6000};
inline constexpr int kTriesMax = 3;  // boot.cmd counts no further

using Sector = uint8_t[kSectorBytes];

struct SlotState {
  char good = 'a';
  char trial = 0;  // 0: none
  int left = 0;    // starts of the trial that are left

  bool operator==(const SlotState& other) const {
    return good == other.good && trial == other.trial && left == other.left;
  }
};

enum class StateFrom : uint8_t { kFirst, kSecond, kNeither };

constexpr bool is_slot(char slot) { return slot == 'a' || slot == 'b'; }

StateFrom read_state(const Sector& first, const Sector& second, SlotState& out);
void put_state(const SlotState& state, Sector& out);

}  // namespace pirvs::card
