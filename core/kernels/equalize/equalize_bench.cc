// Goal (x86-64): 0.15 ms.
#include "core/kernels/equalize/equalize.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

void bench_equalize(benchmark::State& state) {
  const cv::Mat image = bench::image(0);
  const ImageView in = bench::view(image);
  cv::Mat out(image.size(), CV_8U), out_opencv(image.size(), CV_8U);
  bench::compare(state, {1, [&] { equalize_neon(in, out.data, out.cols); },
                         [&] { equalize_ref(in, out.data, out.cols); },
                         [&] { cv::equalizeHist(image, out_opencv); }});
}
BENCHMARK(bench_equalize)->Name("equalize_752x480")->Apply(bench::rounds);

void bench_equalize_by_a_quarter(benchmark::State& state) {
  const cv::Mat image = bench::image(0);
  const ImageView in = bench::view(image);
  cv::Mat out(image.size(), CV_8U), out_opencv(image.size(), CV_8U);
  bench::compare(state, {1, [&] { equalize_neon(in, out.data, out.cols, 4); },
                         [&] { equalize_ref(in, out.data, out.cols, 4); },
                         [&] { cv::equalizeHist(image, out_opencv); }});
}
BENCHMARK(bench_equalize_by_a_quarter)->Name("equalize_752x480_by_4th_rows")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
