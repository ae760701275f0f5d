// Goals (x86-64): deform 1500 ns, deform_step 150 ns.
#include "core/kernels/lk/deform.h"

#include "core/kernels/kernel_bench.h"

namespace pirvs {
namespace {

constexpr int kPoints = 300;

struct Scene {
  cv::Mat before = bench::image(0), after = bench::image(1);
  ImageView from = bench::view(before), to = bench::view(after);
  std::vector<cv::Point2f> points = bench::points(kPoints);
  std::vector<KeyPatch> keys = std::vector<KeyPatch>(kPoints);
  std::vector<DeformedPatch> patches = std::vector<DeformedPatch>(kPoints);
  std::vector<bool> usable = std::vector<bool>(kPoints);
  Deformation deformation{1.1f, 0.1f, -0.05f, 0.95f, 1.1f};

  Scene() {
    for (int i = 0; i < kPoints; ++i) (void)key_patch(from, points[i].x, points[i].y, keys[i]);
  }
};

template <auto Deform>
void deform_all(Scene& s) {
  for (int i = 0; i < kPoints; ++i) {
    s.usable[i] = Deform(s.keys[i], s.deformation, 30.0f, s.patches[i]);
  }
}

template <auto Step>
void step_all(Scene& s) {
  for (int i = 0; i < kPoints; ++i) {
    if (!s.usable[i]) continue;
    float x = s.points[i].x, y = s.points[i].y;
    Deformation d = s.deformation;
    benchmark::DoNotOptimize(Step(s.from, s.patches[i], x, y, d));
    benchmark::DoNotOptimize(x);
  }
}

void draw(benchmark::State& state) {
  Scene s;
  bench::compare(
      state,
      {kPoints, [&] { deform_all<deform_neon>(s); }, [&] { deform_all<deform_ref>(s); }, {}});
}
BENCHMARK(draw)->Name("deform")->Apply(bench::rounds);

void step(benchmark::State& state) {
  Scene s;
  deform_all<deform_neon>(s);
  bench::compare(
      state,
      {kPoints, [&] { step_all<deform_step_neon>(s); }, [&] { step_all<deform_step_ref>(s); }, {}});
}
BENCHMARK(step)->Name("deform_step")->Apply(bench::rounds);

}  // namespace
}  // namespace pirvs
