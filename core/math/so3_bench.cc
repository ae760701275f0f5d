#include "core/math/so3.h"

#include <benchmark/benchmark.h>

#include "core/math/trig.h"

namespace pirvs {
namespace {

// Angles as an integrator (small) and as an error state or a loop (large) has them.
void so3_exp_bench(benchmark::State& state) {
  Vec3 phi = Vec3(0.3, -0.5, 0.7) * (1e-3 * static_cast<double>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(phi);
    benchmark::DoNotOptimize(so3_exp(phi));
  }
}
BENCHMARK(so3_exp_bench)->Name("so3_exp/milliscale")->Arg(1)->Arg(1000);

void so3_log_bench(benchmark::State& state) {
  Mat3 R = so3_exp(Vec3(0.3, -0.5, 0.7));
  for (auto _ : state) {
    benchmark::DoNotOptimize(R);
    benchmark::DoNotOptimize(so3_log(R));
  }
}
BENCHMARK(so3_log_bench)->Name("so3_log");

void sincos_bench(benchmark::State& state) {
  double x = 0.7, s, c;
  for (auto _ : state) {
    benchmark::DoNotOptimize(x);
    sincos(x, s, c);
    benchmark::DoNotOptimize(s + c);
  }
}
BENCHMARK(sincos_bench)->Name("sincos");

void arctan2_bench(benchmark::State& state) {
  double y = 0.7, x = 0.9;
  for (auto _ : state) {
    benchmark::DoNotOptimize(y);
    benchmark::DoNotOptimize(arctan2(y, x));
  }
}
BENCHMARK(arctan2_bench)->Name("arctan2");

}  // namespace
}  // namespace pirvs
