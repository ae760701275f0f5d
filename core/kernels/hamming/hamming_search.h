// The search of both variants over their own distance. Private to core/kernels/hamming.
#pragma once

#include "core/kernels/hamming/hamming.h"

namespace pirvs::hamming_detail {

template <class Distance>
inline void search(const Descriptor& q, const Descriptor* set, int n, int& best, int& best_distance,
                   int& second_distance, Distance distance) {
  best = -1;
  best_distance = second_distance = kHammingNone;
  for (int i = 0; i < n; ++i) {
    const int bits = distance(q, set[i]);
    if (bits >= second_distance) continue;
    if (bits < best_distance) {
      second_distance = best_distance;
      best_distance = bits;
      best = i;
    } else {
      second_distance = bits;
    }
  }
}

}  // namespace pirvs::hamming_detail
