// Goal (x86-64): 1 us. OpenCV's is ORB::compute with the angle given, one level; its blur of the
// whole image is its way of smoothing and is counted, as ours smooths per patch.
#include "core/kernels/describe/describe.h"

#include <opencv2/features2d.hpp>

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kPoints = 300;

template <auto Describe>
void run(const ImageView& im, const std::vector<cv::Point2f>& points) {
  for (const cv::Point2f& p : points) {
    Descriptor descriptor;
    Describe(im, p.x, p.y, 0.8f, 0.6f, descriptor);
    benchmark::DoNotOptimize(descriptor);
  }
}

void bench_describe(benchmark::State& state) {
  const cv::Mat image = bench::image(0);
  const ImageView im = bench::view(image);
  const std::vector<cv::Point2f> points = bench::points(kPoints);
  std::vector<cv::KeyPoint> keypoints;
  for (const cv::Point2f& p : points) keypoints.emplace_back(p, 31.0f, 36.87f, 1.0f, 0);
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(kPoints, 1.2f, 1);
  cv::Mat descriptors;
  bench::compare(state, {kPoints, [&] { run<describe_neon>(im, points); },
                         [&] { run<describe_ref>(im, points); },
                         [&] { orb->compute(image, keypoints, descriptors); }});
}
BENCHMARK(bench_describe)->Name("describe")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
