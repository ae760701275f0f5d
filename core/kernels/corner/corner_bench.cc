// Goal (x86-64): 3 us for 40 x 40 px. OpenCV: response of the same pixels, then its maximum.
#include "core/kernels/corner/corner.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kSize = 40;

template <auto Best>
void run(const ImageView& im) {
  for (int y = kCornerMargin_px; y + kSize + kCornerMargin_px <= im.height; y += kSize)
    for (int x = kCornerMargin_px; x + kSize + kCornerMargin_px <= im.width; x += kSize) {
      Corner corner;
      benchmark::DoNotOptimize(Best(im, x, y, kSize, kSize, 1.0f, corner));
      benchmark::DoNotOptimize(corner);
    }
}

void bench_corner(benchmark::State& state) {
  const cv::Mat image = bench::image(0);
  const ImageView im = bench::view(image);
  const int cells =
      (im.width - 2 * kCornerMargin_px) / kSize * ((im.height - 2 * kCornerMargin_px) / kSize);
  cv::Mat response;
  bench::compare(state,
                 {cells, [&] { run<corner_best_neon>(im); }, [&] { run<corner_best_ref>(im); },
                  [&] {
                    for (int i = 0; i < cells; ++i) {
                      const cv::Rect cell(i % 18 * kSize, i / 18 * kSize, kSize, kSize);
                      cv::cornerMinEigenVal(image(cell), response, 5, 3);
                      cv::Point best;
                      cv::minMaxLoc(response, nullptr, nullptr, nullptr, &best);
                      benchmark::DoNotOptimize(best);
                    }
                  }});
}
BENCHMARK(bench_corner)->Name("corner_best_40x40")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
