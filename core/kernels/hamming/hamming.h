// How many bits differ between two descriptors, and which of many differs least.
// In      Descriptors of describe(); set: n >= 0 of them.
// Out     0..256. hamming_best: index and distance of the nearest (the first among equals), and the
//         distance of the second nearest. What does not exist: index -1, distance kHammingNone.
// Errors  None.
// Cost    2 ns per pair x86-64 (make bench K=hamming).
// Goal    A72 cycles: hamming_best 11 a pair (make bench BOARD=qemu-virt).
// Source  Hamming, "Error Detecting and Error Correcting Codes", 1950.
#pragma once

#include "core/kernels/describe/describe.h"

namespace pirvs {

inline constexpr int kHammingNone = 257;

int hamming_ref(const Descriptor& a, const Descriptor& b);
int hamming_neon(const Descriptor& a, const Descriptor& b);

void hamming_best_ref(const Descriptor& q, const Descriptor* set, int n, int& best,
                      int& best_distance, int& second_distance);
void hamming_best_neon(const Descriptor& q, const Descriptor* set, int n, int& best,
                       int& best_distance, int& second_distance);

inline int hamming(const Descriptor& a, const Descriptor& b) { return hamming_neon(a, b); }

inline void hamming_best(const Descriptor& q, const Descriptor* set, int n, int& best,
                         int& best_distance, int& second_distance) {
  hamming_best_neon(q, set, n, best, best_distance, second_distance);
}

}  // namespace pirvs
