#include "board/bare/bench.h"

#include <cmath>

#include "core/base/limits.h"
#include "core/camera/camera.h"
#include "core/kernels/corner/corner.h"
#include "core/kernels/describe/describe.h"
#include "core/kernels/equalize/equalize.h"
#include "core/kernels/grey/grey.h"
#include "core/kernels/hamming/hamming.h"
#include "core/kernels/lk/lk.h"
#include "core/kernels/pyramid/pyramid.h"
#include "core/kernels/zssd/zssd.h"
#include "core/trace/trace.h"

namespace pirvs::board {
namespace {

constexpr int kPoints = 200;
constexpr int kScan = 16;         // positions along a row, for zssd
constexpr int kIterations = 4;    // for lk
constexpr int kBin_px = 36;       // for corner
constexpr float kMargin_px = 48;  // of points to the border: room for kBin_px, kScan and patches

struct Point {
  float x, y;
};

// What the kernels read and write: static, like everything here.
struct Scene {
  ImageView before, after;
  Point points[kPoints];
  LkPatch patches[kPoints];
  Descriptor descriptors[kPoints];
  Camera camera[2];  // one per model
  Vec3 bearings_C[kPoints];
  alignas(64) uint8_t out[kImagePixelsMax];
  volatile uint32_t sink;  // results that nobody else wants
};

[[gnu::section(".bss.pools")]] Scene scene;

uint64_t pixels(const Scene& s) {
  return static_cast<uint64_t>(s.before.width) * static_cast<uint64_t>(s.before.height);
}

// The image's bytes, two a pixel.
RawImage raw_of(const ImageView& image) {
  return {image.data, image.stride, image.width / 2, image.height};
}

uint64_t grey_from_pairs_work(Scene& s) {
  grey_from_pairs(raw_of(s.before), s.out, s.before.width);
  return pixels(s) / 2;
}

uint64_t grey_from_words_work(Scene& s) {
  grey_from_words(raw_of(s.before), 4, s.out, s.before.width);
  return pixels(s) / 2;
}

uint64_t equalize_work(Scene& s) {
  equalize(s.before, s.out, s.before.width);
  return pixels(s);
}

uint64_t pyramid_work(Scene& s) {
  pyramid_down(s.before, s.out, s.before.width);
  return pixels(s);
}

uint64_t corner_work(Scene& s) {
  for (const Point& p : s.points) {
    Corner corner{};
    const bool found =
        corner_best(s.before, static_cast<int>(p.x) - kBin_px / 2,
                    static_cast<int>(p.y) - kBin_px / 2, kBin_px, kBin_px, 0, corner);
    s.sink = s.sink + found;
  }
  return kPoints * kBin_px * kBin_px;
}

uint64_t lk_extract_work(Scene& s) {
  for (int i = 0; i < kPoints; ++i) {
    s.patches[i].usable = false;
    (void)lk_extract(s.before, s.points[i].x, s.points[i].y, s.patches[i]);
  }
  return kPoints;
}

uint64_t lk_align_work(Scene& s) {
  uint64_t patches = 0;
  for (int i = 0; i < kPoints; ++i) {
    if (!s.patches[i].usable) continue;
    float x = s.points[i].x, y = s.points[i].y, residual_grey = 0;
    patches += lk_align(s.after, s.patches[i], x, y, kIterations, 0.0f, residual_grey);
  }
  return patches * kIterations;
}

uint64_t describe_work(Scene& s) {
  for (int i = 0; i < kPoints; ++i)
    describe(s.before, s.points[i].x, s.points[i].y, 0.96f, 0.28f, s.descriptors[i]);
  return kPoints;
}

uint64_t hamming_work(Scene& s) {
  for (const Descriptor& q : s.descriptors) {
    int best, distance, second;
    hamming_best(q, s.descriptors, kPoints, best, distance, second);
    s.sink = s.sink + static_cast<uint32_t>(best);
  }
  return kPoints * kPoints;
}

template <auto Zssd>
uint64_t zssd_work(Scene& s) {
  uint32_t sum = 0;
  for (const Point& p : s.points) {
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    for (int i = 0; i < kScan; ++i)
      sum += Zssd(s.before.row(y) + x, s.before.stride, s.after.row(y) + x + i, s.after.stride);
  }
  s.sink = sum;
  return kPoints * kScan;
}

template <int kModel>
uint64_t unproject_work(Scene& s) {
  for (int i = 0; i < kPoints; ++i) {
    if (!s.camera[kModel].unproject(Vec2(s.points[i].x, s.points[i].y), s.bearings_C[i]))
      s.bearings_C[i] = Vec3::UnitZ();
  }
  return kPoints;
}

template <int kModel>
uint64_t project_work(Scene& s) {
  Vec2 uv;
  Mat23 J;
  for (const Vec3& bearing_C : s.bearings_C)
    s.sink = s.sink + s.camera[kModel].project(bearing_C, uv, J);
  return kPoints;
}

struct Row {
  TracePlace place;
  const char* unit;
  int repeats;
  uint64_t (*work)(Scene& scene);  // returns how many units it did
};

// In order: lk_align needs the patches, hamming the descriptors, project the bearings before it.
Row rows[] = {
    {TracePlace("bench.grey_from_pairs"), "pixel", 2, grey_from_pairs_work},
    {TracePlace("bench.grey_from_words"), "pixel", 2, grey_from_words_work},
    {TracePlace("bench.equalize"), "pixel", 1, equalize_work},
    {TracePlace("bench.pyramid_down"), "pixel", 2, pyramid_work},
    {TracePlace("bench.corner_best"), "pixel", 2, corner_work},
    {TracePlace("bench.lk_extract"), "call", 2, lk_extract_work},
    {TracePlace("bench.lk_align"), "iteration", 1, lk_align_work},
    {TracePlace("bench.describe"), "call", 1, describe_work},
    {TracePlace("bench.hamming_best"), "pair", 1, hamming_work},
    {TracePlace("bench.zssd_8x8"), "call", 2, zssd_work<zssd_8x8>},
    {TracePlace("bench.zssd_16x16"), "call", 1, zssd_work<zssd_16x16>},
    {TracePlace("bench.radtan_unproject"), "call", 2, unproject_work<0>},
    {TracePlace("bench.radtan_project"), "call", 5, project_work<0>},
    {TracePlace("bench.fisheye_unproject"), "call", 2, unproject_work<1>},
    {TracePlace("bench.fisheye_project"), "call", 5, project_work<1>},
};

void prepare(Scene& s, const ImageView& before, const ImageView& after) {
  s.before = before;
  s.after = after;
  const float width_px = static_cast<float>(before.width) - 2 * kMargin_px;
  const float height_px = static_cast<float>(before.height) - 2 * kMargin_px;
  for (int i = 0; i < kPoints; ++i) {  // spread, at many sub-pixel fractions
    const float x = static_cast<float>(i) * 83.31f, y = static_cast<float>(i) * 37.77f;
    s.points[i].x = kMargin_px + x - width_px * static_cast<float>(static_cast<int>(x / width_px));
    s.points[i].y =
        kMargin_px + y - height_px * static_cast<float>(static_cast<int>(y / height_px));
  }
  const double radtan[4] = {-0.283, 0.074, 1.9e-4, 1.8e-5};
  const double fisheye[4] = {3.5e-3, 7.2e-4, -2.1e-3, 2.0e-4};
  for (int m = 0; m < 2; ++m) {
    Camera& camera = s.camera[m];
    camera.model = m == 0 ? CameraModel::kPinholeRadtan : CameraModel::kKannalaBrandt;
    camera.width = before.width;
    camera.height = before.height;
    camera.fx = camera.fy = m == 0 ? 458.0 : 190.0;
    camera.cx = 0.5 * before.width;
    camera.cy = 0.5 * before.height;
    for (int i = 0; i < 4; ++i) camera.d[i] = m == 0 ? radtan[i] : fisheye[i];
  }
}

}  // namespace

void bench_kernels(const ImageView& before, const ImageView& after,
                   void (*done)(const BenchResult& result)) {
  prepare(scene, before, after);
  for (Row& row : rows) {
    (void)row.work(scene);  // what it reads is in the caches afterwards, as far as it fits
    BenchResult result = {row.place.name, row.unit, 0, {}};
    const bsp::Cycles begin = bsp::read_cycles();
    {
      const TraceScope scope(row.place);
      for (int i = 0; i < row.repeats; ++i) result.units += row.work(scene);
    }
    const bsp::Cycles end = bsp::read_cycles();
    result.spent = {end.cycles - begin.cycles, end.instructions - begin.instructions};
    done(result);
  }
}

}  // namespace pirvs::board
