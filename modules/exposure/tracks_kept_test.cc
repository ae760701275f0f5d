// What auto-exposure is for: tracks that go on through a sudden change of the light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>
#include <set>
#include <vector>

#include "modules/exposure/auto_exposure.h"
#include "modules/frontend/frontend.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Texture;

constexpr int kSide = 240, kDelay = 3, kChange = 12, kFrames = 60;
constexpr ExposureSetting kRight = {0.004, 1};  // for light 1

struct Tracked {
  size_t before = 0;  // tracks when the light changes
  size_t kept = 0;    // of these, how many are there at the end
  size_t least = 1000, last = 0;
};

// The light becomes another one from frame kChange on, in so many frames.
struct Change {
  double light = 1;
  int frames = 1;

  double at(int frame) const {
    const double done = std::clamp((frame - kChange + 1.0) / frames, 0.0, 1.0);
    return std::pow(light, done);
  }
};

// A camera before a texture that slides by.
Tracked track(const Change& change, bool controlled) {
  const Texture texture(3);
  Random random(8);
  Camera camera;
  camera.width = camera.height = kSide;
  camera.fx = camera.fy = 150;
  camera.cx = camera.cy = (kSide - 1) / 2.0;
  FrontendParams params;
  params.bin_px = 24;
  const auto frontend = std::make_unique<Frontend>();
  frontend->configure(camera, params);
  AutoExposure controller;
  controller.configure({}, 276, 1.0 / 60);
  controller.set_range({{2e-5, 1}, {0.1, 16}, {1e-5, 1.0 / 16}});
  std::deque<ExposureSetting> settings(kDelay, kRight);  // newest first
  std::vector<uint8_t> pixels(kSide * kSide);
  std::set<TrackId> before;
  Tracked out;
  for (int i = 0; i < kFrames; ++i) {
    const double now = change.at(i) * settings.back().product() / kRight.product();
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double grey = 0.75 * texture.at((x - 0.8 * i) / 10, (y + 0.5 * i) / 10);
        const double seen = std::lround(now * grey + random.gauss(1.5));
        pixels[size_t(y * kSide + x)] = uint8_t(std::clamp(seen, 0.0, 255.0));
      }
    }
    const ImageView view = {pixels.data(), kSide, kSide, kSide};
    const TimeNs t = from_seconds(1 + i / 60.0);
    ExposureFrame frame;
    frame.t = t;
    frame.images = &view;
    frame.count = 1;
    ExposureSetting setting = settings.front();
    if (controlled) (void)controller.frame(frame, setting);
    settings.push_front(setting);
    settings.pop_back();
    frontend->predict(Mat3::Identity());
    EXPECT_EQ(frontend->process(view, t, Vec3(0, 9.81, 0)), Status::kOk);
    const size_t tracks = frontend->tracks().size();
    if (i == kChange - 1) {
      for (const Track& track : frontend->tracks()) before.insert(track.id);
    }
    if (i >= kChange) out.least = std::min(out.least, tracks);
    out.last = tracks;
  }
  out.before = before.size();
  for (const Track& track : frontend->tracks()) out.kept += before.count(track.id);
  return out;
}

struct Case {
  Change change;
  size_t kept, kept_fixed;  // at least with the controller, at most without
};
// A third of the light at once does little harm without control either: contrast is a part of how a
// track is followed. The control adds a second change, which costs as many tracks again.

TEST(auto_exposure, tracks_stay_through_a_change_of_light) {
  constexpr Case kCases[] = {
      {{0.3, 1}, 34, 55}, {{2.5, 1}, 38, 25}, {{0.02, 30}, 45, 3}, {{8, 30}, 45, 3}};
  for (const Case& c : kCases) {
    const Tracked with = track(c.change, true), without = track(c.change, false);
    std::printf(
        "light x %.2f in %d frames: of %zu tracks %zu kept, %zu at the end, %zu at least; "
        "with fixed exposure %zu kept, %zu, %zu\n",
        c.change.light, c.change.frames, with.before, with.kept, with.last, with.least,
        without.kept, without.last, without.least);
    EXPECT_GE(with.kept, c.kept);
    EXPECT_GE(with.least, with.before * 9 / 10);
    EXPECT_LE(without.kept, c.kept_fixed);
    if (c.change.light != 0.3) EXPECT_GE(with.kept, without.kept + 5);
  }
}

}  // namespace
}  // namespace pirvs
