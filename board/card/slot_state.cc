#include "board/card/slot_state.h"

#include <cstring>
#include <string_view>

#include "core/base/crc32.h"
#include "core/base/text.h"

namespace pirvs::card {
namespace {

constexpr size_t kCrcBytes = 4;

uint32_t crc_of(const Sector& sector) {
  Crc32 crc;
  crc.add(sector + kCrcBytes, kSectorBytes - kCrcBytes);
  return crc.value();
}

uint32_t little_endian(const uint8_t* bytes) {
  return uint32_t{bytes[0]} | uint32_t{bytes[1]} << 8 | uint32_t{bytes[2]} << 16 |
         uint32_t{bytes[3]} << 24;
}

// The value of a key; empty if there is none.
std::string_view find(const Sector& sector, std::string_view key) {
  const char* at = reinterpret_cast<const char*>(sector) + kCrcBytes;
  const char* const end = reinterpret_cast<const char*>(sector) + kSectorBytes;
  while (at < end && *at != 0) {
    const std::string_view line(at, strnlen(at, static_cast<size_t>(end - at)));
    if (line.substr(0, key.size()) == key && line.substr(key.size(), 1) == "=") {
      return line.substr(key.size() + 1);
    }
    at += line.size() + 1;
  }
  return {};
}

bool read_sector(const Sector& sector, SlotState& out) {
  if (little_endian(sector) != crc_of(sector)) return false;
  const std::string_view good = find(sector, "good"), trial = find(sector, "trial"),
                         left = find(sector, "left");
  if (good.size() != 1 || !is_slot(good[0])) return false;
  out = {};
  out.good = good[0];
  if (trial.size() == 1 && is_slot(trial[0])) out.trial = trial[0];
  if (left.size() == 1 && left[0] >= '0' && left[0] <= '0' + kTriesMax) out.left = left[0] - '0';
  return true;
}

}  // namespace

StateFrom read_state(const Sector& first, const Sector& second, SlotState& out) {
  if (read_sector(first, out)) return StateFrom::kFirst;
  if (read_sector(second, out)) return StateFrom::kSecond;
  out = {};
  return StateFrom::kNeither;
}

void put_state(const SlotState& state, Sector& out) {
  std::memset(out, 0, sizeof out);
  char* const lines = reinterpret_cast<char*>(out) + kCrcBytes;
  TextWriter text(lines, kSectorBytes - kCrcBytes);
  text.put("good=").put(state.good).put('\n');
  text.put("left=").number(state.left).put('\n');
  if (state.trial != 0) text.put("trial=").put(state.trial).put('\n');
  for (size_t i = 0; i < text.size(); ++i) {
    if (lines[i] == '\n') lines[i] = 0;
  }
  const uint32_t crc = crc_of(out);
  for (size_t i = 0; i < kCrcBytes; ++i) out[i] = static_cast<uint8_t>(crc >> 8 * i);
}

}  // namespace pirvs::card
