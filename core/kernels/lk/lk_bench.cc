// Goals (x86-64): 250 ns per iteration. lk_point is one point on one level: extraction and four
// iterations; OpenCV gets its gradients for nothing (precomputed), as it has them for all points.
#include "core/kernels/lk/lk.h"

#include <opencv2/video/tracking.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kPoints = 300;
constexpr int kIterations = 4;

struct Scene {
  cv::Mat before = bench::image(0), after = bench::image(1);
  ImageView from = bench::view(before), to = bench::view(after);
  std::vector<cv::Point2f> points = bench::points(kPoints);
  std::vector<LkPatch> patches = std::vector<LkPatch>(kPoints);
};

template <auto Extract>
void extract_all(Scene& s) {
  for (int i = 0; i < kPoints; ++i) Extract(s.from, s.points[i].x, s.points[i].y, s.patches[i]);
}

template <auto Align>
void align_all(Scene& s, int iterations) {
  for (int i = 0; i < kPoints; ++i) {
    if (!s.patches[i].usable) continue;
    float x = s.points[i].x, y = s.points[i].y, residual = 0;
    benchmark::DoNotOptimize(Align(s.to, s.patches[i], x, y, iterations, 0.0f, residual));
    benchmark::DoNotOptimize(x);
  }
}

void extract(benchmark::State& state) {
  Scene s;
  bench::compare(state, {kPoints,
                         [&] { extract_all<lk_extract_neon>(s); },
                         [&] { extract_all<lk_extract_ref>(s); },
                         {}});
}
BENCHMARK(extract)->Name("lk_extract")->Apply(bench::rounds);

void align(benchmark::State& state) {
  Scene s;
  extract_all<lk_extract>(s);
  int usable = 0;
  for (const LkPatch& patch : s.patches) usable += patch.usable;
  bench::compare(state, {usable * kIterations,
                         [&] { align_all<lk_align_neon>(s, kIterations); },
                         [&] { align_all<lk_align_ref>(s, kIterations); },
                         {}});
}
BENCHMARK(align)->Name("lk_align_per_iteration")->Apply(bench::rounds);

void point(benchmark::State& state) {
  Scene s;
  const cv::Size window(kLkSize, kLkSize);
  std::vector<cv::Mat> from, to;
  cv::buildOpticalFlowPyramid(s.before, from, window, 0, true);
  cv::buildOpticalFlowPyramid(s.after, to, window, 0, false);
  std::vector<cv::Point2f> found;
  std::vector<uint8_t> status;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT, kIterations, 0);
  bench::compare(state, {kPoints,
                         [&] {
                           extract_all<lk_extract_neon>(s);
                           align_all<lk_align_neon>(s, kIterations);
                         },
                         [&] {
                           extract_all<lk_extract_ref>(s);
                           align_all<lk_align_ref>(s, kIterations);
                         },
                         [&] {
                           cv::calcOpticalFlowPyrLK(from, to, s.points, found, status,
                                                    cv::noArray(), window, 0, stop);
                         }});
}
BENCHMARK(point)->Name("lk_point")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
