// Goal (x86-64): 10 us a pair.
#include "modules/exposure/auto_exposure.h"

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

void bench_frame(benchmark::State& state) {
  const cv::Mat images[2] = {bench::image(0), bench::image(1)};
  const ImageView views[2] = {bench::view(images[0]), bench::view(images[1])};
  AutoExposure controller;
  controller.configure({}, 458, 0.05);
  controller.set_range({{2e-5, 1}, {0.1, 16}, {1e-5, 1.0 / 16}});
  ExposureFrame frame;
  frame.images = views;
  frame.count = 2;
  bench::compare(state, {1,
                         [&] {
                           frame.t += 50'000'000;
                           frame.taken = controller.setting();
                           ExposureSetting out;
                           controller.turn(0.5);
                           benchmark::DoNotOptimize(controller.frame(frame, out));
                         },
                         {},
                         {}});
}
BENCHMARK(bench_frame)->Name("exposure_pair_752x480")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
