// A scan of 64 positions along a row for each of 300 points, per position. OpenCV: matchTemplate
// with TM_CCOEFF, which removes the means too, over the same positions.
#include "core/kernels/zssd/zssd.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kPoints = 300, kPositions = 64;

template <int kSize, auto Zssd>
void run(const ImageView& from, const ImageView& to, const std::vector<cv::Point2f>& points) {
  for (const cv::Point2f& p : points) {
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    const int x_scan = std::min(x, to.width - kPositions - kSize);
    for (int i = 0; i < kPositions; ++i)
      benchmark::DoNotOptimize(
          Zssd(from.row(y) + x, from.stride, to.row(y) + x_scan + i, to.stride));
  }
}

template <int kSize, auto Neon, auto Ref>
void bench_zssd(benchmark::State& state) {
  const cv::Mat before = bench::image(0), after = bench::image(1);
  const ImageView from = bench::view(before), to = bench::view(after);
  const std::vector<cv::Point2f> points = bench::points(kPoints);
  cv::Mat scores;
  bench::compare(state, {kPoints * kPositions, [&] { run<kSize, Neon>(from, to, points); },
                         [&] { run<kSize, Ref>(from, to, points); },
                         [&] {
                           for (const cv::Point2f& p : points) {
                             const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
                             const int x_scan = std::min(x, to.width - kPositions - kSize);
                             cv::matchTemplate(
                                 after(cv::Rect(x_scan, y, kPositions + kSize - 1, kSize)),
                                 before(cv::Rect(x, y, kSize, kSize)), scores, cv::TM_CCOEFF);
                           }
                         }});
}
BENCHMARK_TEMPLATE(bench_zssd, 8, zssd_8x8_neon, zssd_8x8_ref)
    ->Name("zssd_8x8")
    ->Apply(bench::rounds);
BENCHMARK_TEMPLATE(bench_zssd, 16, zssd_16x16_neon, zssd_16x16_ref)
    ->Name("zssd_16x16")
    ->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
