// Goal (x86-64): pairs 0.015 ms, words 0.05 ms.
#include "core/kernels/grey/grey.h"

#include <opencv2/imgproc.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

struct Images {
  cv::Mat yuyv = cv::Mat(480, 752, CV_8UC2, cv::Scalar(90, 128));
  cv::Mat out = cv::Mat(480, 752, CV_8U), out_opencv;
  RawImage in = {yuyv.data, int(yuyv.step), yuyv.cols, yuyv.rows};
};

void bench_pairs(benchmark::State& state) {
  Images images;
  bench::compare(state, {1, [&] { grey_from_pairs_neon(images.in, images.out.data, 752); },
                         [&] { grey_from_pairs_ref(images.in, images.out.data, 752); },
                         [&] { cv::extractChannel(images.yuyv, images.out_opencv, 0); }});
}
BENCHMARK(bench_pairs)->Name("grey_from_pairs_752x480")->Apply(bench::rounds);

void bench_words(benchmark::State& state) {
  Images images;
  const cv::Mat words(480, 752, CV_16U, images.yuyv.data, images.yuyv.step);
  bench::compare(state, {1, [&] { grey_from_words_neon(images.in, 4, images.out.data, 752); },
                         [&] { grey_from_words_ref(images.in, 4, images.out.data, 752); },
                         [&] { words.convertTo(images.out_opencv, CV_8U, 1.0 / 16); }});
}
BENCHMARK(bench_words)->Name("grey_from_words_752x480")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
