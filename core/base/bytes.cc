#include "core/base/bytes.h"

namespace pirvs {
namespace {

// As many bytes as a compiler moves through registers, at once: never by calling memcpy.
template <size_t kSize>
struct Block {
  uint8_t bytes[kSize];

  static Block at(const uint8_t* p) {
    Block block;
    __builtin_memcpy(&block, p, kSize);
    return block;
  }
  void store(uint8_t* p) const { __builtin_memcpy(p, this, kSize); }
};

constexpr size_t kStride = 64;

// kSize <= size <= 2 kSize: the first and the last kSize bytes are all of them.
template <size_t kSize>
inline void move_ends(uint8_t* to, const uint8_t* from, size_t size) {
  const auto head = Block<kSize>::at(from), tail = Block<kSize>::at(from + size - kSize);
  head.store(to);
  tail.store(to + size - kSize);
}

inline void move_small(uint8_t* to, const uint8_t* from, size_t size) {
  if (size >= 32) return move_ends<32>(to, from, size);
  if (size >= 16) return move_ends<16>(to, from, size);
  if (size >= 8) return move_ends<8>(to, from, size);
  if (size >= 4) return move_ends<4>(to, from, size);
  if (size >= 2) return move_ends<2>(to, from, size);
  if (size == 1) *to = *from;
}

template <size_t kSize>
inline void fill_ends(uint8_t* to, uint64_t eight, size_t size) {
  Block<kSize> block;
  if constexpr (kSize <= 8) {
    __builtin_memcpy(&block, &eight, kSize);
  } else {
    for (size_t i = 0; i < kSize; i += 8) __builtin_memcpy(block.bytes + i, &eight, 8);
  }
  block.store(to);
  block.store(to + size - kSize);
}

inline void fill_small(uint8_t* to, uint64_t eight, size_t size) {
  if (size >= 32) return fill_ends<32>(to, eight, size);
  if (size >= 16) return fill_ends<16>(to, eight, size);
  if (size >= 8) return fill_ends<8>(to, eight, size);
  if (size >= 4) return fill_ends<4>(to, eight, size);
  if (size >= 2) return fill_ends<2>(to, eight, size);
  if (size == 1) *to = static_cast<uint8_t>(eight);
}

}  // namespace

void fill_bytes(void* to, uint8_t value, size_t size) {
  auto* p = static_cast<uint8_t*>(to);
  const uint64_t eight = 0x0101'0101'0101'0101u * value;
  if (size < kStride) return fill_small(p, eight, size);
  for (const uint8_t* const last = p + size - kStride; p < last; p += kStride)
    fill_ends<kStride / 2>(p, eight, kStride);
  fill_ends<kStride / 2>(static_cast<uint8_t*>(to) + size - kStride, eight, kStride);
}

void move_bytes(void* to, const void* from, size_t size) {
  auto* const p = static_cast<uint8_t*>(to);
  const auto* const q = static_cast<const uint8_t*>(from);
  if (size < kStride) return move_small(p, q, size);
  const size_t last = size - kStride;
  // What the last block reads is read first: the others may overwrite it.
  if (reinterpret_cast<uintptr_t>(p) - reinterpret_cast<uintptr_t>(q) >= size) {
    const auto tail = Block<kStride>::at(q + last);
    for (size_t i = 0; i < last; i += kStride) Block<kStride>::at(q + i).store(p + i);
    tail.store(p + last);
  } else {  // to begins inside from: from the end
    const auto head = Block<kStride>::at(q);
    for (size_t i = last; i > 0; i = i > kStride ? i - kStride : 0)
      Block<kStride>::at(q + i).store(p + i);
    head.store(p);
  }
}

}  // namespace pirvs
