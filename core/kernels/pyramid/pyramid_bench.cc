// Goal (x86-64): 0.06 ms.
#include "core/kernels/pyramid/pyramid.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

void bench_pyramid(benchmark::State& state) {
  const cv::Mat image = bench::image(0);
  const ImageView in = bench::view(image);
  cv::Mat out(240, 376, CV_8U), out_opencv;
  bench::compare(state, {1, [&] { pyramid_down_neon(in, out.data, out.cols); },
                         [&] { pyramid_down_ref(in, out.data, out.cols); },
                         [&] { cv::pyrDown(image, out_opencv); }});
}
BENCHMARK(bench_pyramid)->Name("pyramid_down_752x480")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
