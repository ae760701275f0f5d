// Goal (x86-64): 3 ns per pair of descriptors. OpenCV: BFMatcher's batch distance.
#include "core/kernels/hamming/hamming.h"

#include <random>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kSet = 300;

template <auto Best>
void run(const std::vector<Descriptor>& set) {
  for (const Descriptor& q : set) {
    int best, distance, second;
    Best(q, set.data(), kSet, best, distance, second);
    benchmark::DoNotOptimize(best);
  }
}

void bench_hamming(benchmark::State& state) {
  std::mt19937_64 random(1);
  std::vector<Descriptor> set(kSet);
  for (Descriptor& d : set) d = {{random(), random(), random(), random()}};
  const cv::Mat mat(kSet, 32, CV_8U, set.data());
  cv::Mat distances, indices;
  bench::compare(
      state,
      {kSet * kSet, [&] { run<hamming_best_neon>(set); }, [&] { run<hamming_best_ref>(set); },
       [&] { cv::batchDistance(mat, mat, distances, CV_32S, indices, cv::NORM_HAMMING, 2); }});
}
BENCHMARK(bench_hamming)->Name("hamming_best_per_pair")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
