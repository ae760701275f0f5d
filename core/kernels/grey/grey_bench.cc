// Goal (x86-64): pairs 0.015 ms, words 0.05 ms, packed 0.03 ms, bayer 0.13 ms, rgb 0.35 ms,
// limited 0.08 ms.
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

void bench_packed(benchmark::State& state) {
  Images images;
  const RawImage in = {images.yuyv.data, 752 / 4 * 5, 752, 480};
  bench::compare(state, {1, [&] { grey_from_packed_neon(in, 5, images.out.data, 752); },
                         [&] { grey_from_packed_ref(in, 5, images.out.data, 752); }, nullptr});
}
BENCHMARK(bench_packed)->Name("grey_from_packed_752x480")->Apply(bench::rounds);

void bench_bayer(benchmark::State& state) {
  Images images;
  const cv::Mat mosaic(480, 752, CV_8U, images.yuyv.data, images.yuyv.step);
  const RawImage in = {mosaic.data, int(mosaic.step), 752, 480};
  bench::compare(state, {1, [&] { grey_from_bayer_neon(in, images.out.data, 752); },
                         [&] { grey_from_bayer_ref(in, images.out.data, 752); },
                         [&] { cv::cvtColor(mosaic, images.out_opencv, cv::COLOR_BayerBG2GRAY); }});
}
BENCHMARK(bench_bayer)->Name("grey_from_bayer_752x480")->Apply(bench::rounds);

void bench_rgb(benchmark::State& state) {
  Images images;
  const cv::Mat rgb(480, 752, CV_8UC3, cv::Scalar(10, 90, 200));
  const RawImage in = {rgb.data, int(rgb.step), 752, 480};
  bench::compare(state, {1, [&] { grey_from_rgb_neon(in, false, images.out.data, 752); },
                         [&] { grey_from_rgb_ref(in, false, images.out.data, 752); },
                         [&] { cv::cvtColor(rgb, images.out_opencv, cv::COLOR_RGB2GRAY); }});
}
BENCHMARK(bench_rgb)->Name("grey_from_rgb_752x480")->Apply(bench::rounds);

void bench_limited(benchmark::State& state) {
  Images images;
  const cv::Mat grey(480, 752, CV_8U, cv::Scalar(100));
  const RawImage in = {grey.data, int(grey.step), 752, 480};
  bench::compare(state, {1, [&] { grey_from_limited_neon(in, images.out.data, 752); },
                         [&] { grey_from_limited_ref(in, images.out.data, 752); },
                         [&] { grey.convertTo(images.out_opencv, CV_8U, 255.0 / 219, -18.6); }});
}
BENCHMARK(bench_limited)->Name("grey_from_limited_752x480")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
