#include "core/kernels/hamming/hamming.h"
#include "core/kernels/hamming/hamming_search.h"

namespace pirvs {

int hamming_ref(const Descriptor& a, const Descriptor& b) {
  int bits = 0;
  for (int i = 0; i < 256; ++i) bits += ((a.w[i / 64] ^ b.w[i / 64]) >> (i % 64)) & 1;
  return bits;
}

void hamming_best_ref(const Descriptor& q, const Descriptor* set, int n, int& best,
                      int& best_distance, int& second_distance) {
  hamming_detail::search(q, set, n, best, best_distance, second_distance, hamming_ref);
}

}  // namespace pirvs
