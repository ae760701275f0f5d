#include "core/kernels/hamming/hamming.h"
#include "core/kernels/hamming/hamming_search.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

#if defined(__POPCNT__)

// x86 counts 64 bits in one instruction, but not bytes.
inline int count(const Descriptor& a, const Descriptor& b) {
  int bits = 0;
  for (int k = 0; k < 4; ++k) bits += __builtin_popcountll(a.w[k] ^ b.w[k]);
  return bits;
}

#else

// Two counts of at most 8 per byte; the sum of 16 bytes is at most 256, so u16.
inline int count(const Descriptor& a, const Descriptor& b) {
  const uint8x16_t low = vreinterpretq_u8_u64(veorq_u64(vld1q_u64(a.w), vld1q_u64(b.w)));
  const uint8x16_t high = vreinterpretq_u8_u64(veorq_u64(vld1q_u64(a.w + 2), vld1q_u64(b.w + 2)));
  return vaddlvq_u8(vaddq_u8(vcntq_u8(low), vcntq_u8(high)));
}

#endif

}  // namespace

int hamming_neon(const Descriptor& a, const Descriptor& b) { return count(a, b); }

void hamming_best_neon(const Descriptor& q, const Descriptor* set, int n, int& best,
                       int& best_distance, int& second_distance) {
  hamming_detail::search(q, set, n, best, best_distance, second_distance, count);
}

}  // namespace pirvs
