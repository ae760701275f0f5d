#include "modules/output/latency.h"

#include <algorithm>

namespace pirvs {
namespace {

double to_ms(double ns) { return ns * 1e-6; }

// One writer: no read-modify-write is needed.
template <class T>
void add_to(std::atomic<T>& counter) {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

int LatencyHistogram::bucket_of(TimeNs delay) {
  int octave = 0;
  for (TimeNs rest = delay >> (kLog2PerOctave + 1); rest != 0; rest >>= 1) ++octave;
  return octave * kPerOctave + static_cast<int>(delay >> octave);
}

double LatencyHistogram::middle_of(int bucket) {
  const int octave = std::max(0, bucket / kPerOctave - 1);
  const TimeNs low = static_cast<TimeNs>(bucket - octave * kPerOctave) << octave;
  return static_cast<double>(low) + 0.5 * static_cast<double>((TimeNs{1} << octave) - 1);
}

void LatencyHistogram::add(TimeNs delay) {
  const TimeNs bounded = std::clamp<TimeNs>(delay, 0, (TimeNs{1} << kBits) - 1);
  add_to(buckets_[bucket_of(bounded)]);
  if (bounded < min_.load(std::memory_order_relaxed)) min_.store(bounded);
  if (bounded > max_.load(std::memory_order_relaxed)) max_.store(bounded);
  count_.store(count_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

double LatencyHistogram::quantile(double share, uint64_t count) const {
  const auto rank = static_cast<uint64_t>(share * static_cast<double>(count - 1));
  uint64_t below = 0;
  int i = 0;
  for (; i < kBuckets - 1; ++i) {
    below += buckets_[i].load(std::memory_order_relaxed);
    if (below > rank) break;
  }
  return std::clamp(middle_of(i), static_cast<double>(min_.load()),
                    static_cast<double>(max_.load()));
}

LatencySummary LatencyHistogram::summary() const {
  LatencySummary out;
  out.count = count_.load(std::memory_order_acquire);
  if (out.count == 0) return out;
  out.min_ms = to_ms(static_cast<double>(min_.load()));
  out.median_ms = to_ms(quantile(0.5, out.count));
  out.p99_ms = to_ms(quantile(0.99, out.count));
  out.max_ms = to_ms(static_cast<double>(max_.load()));
  return out;
}

}  // namespace pirvs
