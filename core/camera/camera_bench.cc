#include "core/camera/camera.h"

#include <benchmark/benchmark.h>

namespace pirvs {
namespace {

constexpr int kPoints = 256;

Camera camera_of(int model) {
  Camera camera;
  camera.model = static_cast<CameraModel>(model);
  camera.width = 752, camera.height = 480;
  camera.fx = camera.fy = model == 0 ? 458.0 : 190.0;
  camera.cx = 367.0, camera.cy = 248.0;
  const double radtan[4] = {-0.283, 0.074, 1.9e-4, 1.8e-5};
  const double fisheye[4] = {3.5e-3, 7.2e-4, -2.1e-3, 2.0e-4};
  for (int i = 0; i < 4; ++i) camera.d[i] = model == 0 ? radtan[i] : fisheye[i];
  return camera;
}

// Pixels spread over the image, and a point behind each.
struct Points {
  Vec2 uv[kPoints];
  Vec3 p_C[kPoints];

  explicit Points(const Camera& camera) {
    for (int i = 0; i < kPoints; ++i) {
      uv[i] << (i * 37) % camera.width, (i * 101) % camera.height;
      if (!camera.unproject(uv[i], p_C[i])) p_C[i] = Vec3::UnitZ();
      p_C[i] *= 1.0 + i % 10;
    }
  }
};

void project_bench(benchmark::State& state) {
  const Camera camera = camera_of(static_cast<int>(state.range(0)));
  const Points points(camera);
  Vec2 uv;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.project(points.p_C[i++ % kPoints], uv));
    benchmark::DoNotOptimize(uv);
  }
}
BENCHMARK(project_bench)->Name("camera/project/model")->Arg(0)->Arg(1);

void project_jacobian_bench(benchmark::State& state) {
  const Camera camera = camera_of(static_cast<int>(state.range(0)));
  const Points points(camera);
  Vec2 uv;
  Mat23 J;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.project(points.p_C[i++ % kPoints], uv, J));
    benchmark::DoNotOptimize(J);
  }
}
BENCHMARK(project_jacobian_bench)->Name("camera/project_jacobian/model")->Arg(0)->Arg(1);

void unproject_bench(benchmark::State& state) {
  const Camera camera = camera_of(static_cast<int>(state.range(0)));
  const Points points(camera);
  Vec3 bearing_C;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.unproject(points.uv[i++ % kPoints], bearing_C));
    benchmark::DoNotOptimize(bearing_C);
  }
}
BENCHMARK(unproject_bench)->Name("camera/unproject/model")->Arg(0)->Arg(1);

}  // namespace
}  // namespace pirvs
