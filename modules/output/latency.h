// Statistics of a delay in fixed memory: min, median, p99 and max since the start.
// In      add(), from one core.
// Out     summary(), from any core and at any time; what is added meanwhile may be missing.
// Errors  median and p99 are off by 1.6 % at most (half a bucket), min and max are exact. Below 0
//         (the clocks disagree) counts as 0, above 68 s as 68 s.
// Cost    add ~5 ns, summary ~1 us; 4 kB.
// Source  log-linear buckets as in HdrHistogram: 32 for each power of two.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/time.h"

namespace pirvs {

struct LatencySummary {
  uint64_t count = 0;  // 0: the rest means nothing
  double min_ms = 0, median_ms = 0, p99_ms = 0, max_ms = 0;
};

class LatencyHistogram {
 public:
  void add(TimeNs delay);
  LatencySummary summary() const;

 private:
  // Values below 2 kPerOctave have a bucket of their own; then kPerOctave for each power of two.
  static constexpr int kLog2PerOctave = 5;
  static constexpr int kPerOctave = 1 << kLog2PerOctave;
  static constexpr int kBits = 36;  // 68 s
  static constexpr int kBuckets = (kBits - kLog2PerOctave + 1) * kPerOctave;

  static int bucket_of(TimeNs delay);
  static double middle_of(int bucket);
  double quantile(double share, uint64_t count) const;

  std::atomic<uint32_t> buckets_[kBuckets] = {};
  std::atomic<uint64_t> count_{0};
  std::atomic<TimeNs> min_{INT64_MAX}, max_{0};
};

// What the product measures of itself.
struct Latency {
  LatencyHistogram imu_to_pose;        // IMU sample's stamp to its pose published
  LatencyHistogram exposure_to_fused;  // middle of a frame's exposure to its pose published
};

}  // namespace pirvs
