// Auto-exposure before a simulated sensor: response, noise, saturation, delay, flicker.
#include "modules/exposure/auto_exposure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Texture;

constexpr int kWidth = 160, kHeight = 128, kCameras = 2;
constexpr double kPi_ = 3.14159265358979323846;

struct Sensor {
  double light = 1;  // 1: 4 ms at gain 1 give the mean that is aimed at
  double gamma = 1, noise_grey = 2, black_grey = 0;
  int exposure_delay = 2, gain_delay = 1;  // frames from the command to its first image
  bool tells = false;                      // with what an image was taken
  ExposureSetting left = {0.004, 1};       // as somebody left it
  double flicker_hz = 0, modulation = 0;
  double period_s = 1.0 / 60;
  ExposureRange range = {{20e-6, 1}, {0.1, 16}, {10e-6, 1.0 / 16}};
};

// Two cameras before textures, and the controller that is told of each pair.
class Scene {
 public:
  explicit Scene(const Sensor& sensor, const ExposureParams& params = {}, double focal_px = 276)
      : sensor_(sensor), params_(params) {
    const Texture texture(5);
    double sum = 0;
    for (int c = 0; c < kCameras; ++c) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          radiance_[c].push_back(texture.at(x / 8.0 + 100 * c, y / 8.0) / 255);
          sum += radiance_[c].back() / (kCameras * kWidth * kHeight);
        }
      }
      pixels_[c].resize(radiance_[c].size());
    }
    // So that light 1 is right for 4 ms.
    const double wanted = std::pow(double(params.mean_grey) / 255, sensor.gamma);
    scale_ = wanted / (sum * 0.004);
    Random random(3);
    for (int i = 0; i < 10'007; ++i) noise_.push_back(random.gauss(1));
    exposures_.assign(4, sensor.left);
    controller_.configure(params, focal_px, 1.0 / 60);
    controller_.set_range(sensor.range);
  }

  // Exposes a pair, shows it, and obeys. What it was taken with lies in taken().
  void step() {
    taken_ = {at(exposures_, sensor_.exposure_delay).exposure_s,
              at(exposures_, sensor_.gain_delay).gain};
    expose();
    ImageView views[kCameras];
    for (int c = 0; c < kCameras; ++c) views[c] = {pixels_[c].data(), kWidth, kHeight, kWidth};
    ExposureFrame frame;
    frame.t = from_seconds(1000 + sensor_.period_s * frames_);
    frame.images = views;
    frame.count = kCameras;
    if (sensor_.tells) frame.taken = taken_;
    ExposureSetting setting = exposures_.front();
    controller_.turn(rate_rad_s);
    if (controller_.frame(frame, setting)) {
      ++commands_;
      EXPECT_GE(setting.exposure_s, sensor_.range.min.exposure_s);
      EXPECT_LE(setting.exposure_s, sensor_.range.max.exposure_s);
      EXPECT_GE(setting.gain, sensor_.range.min.gain);
      EXPECT_LE(setting.gain, sensor_.range.max.gain);
    }
    exposures_.push_front(setting);
    exposures_.pop_back();
    ++frames_;
  }
  void run(int frames) {
    for (int i = 0; i < frames; ++i) step();
  }

  // Frames until the mean that counts stays within 20 % of its aim for the rest of `frames`.
  int settle(int frames = 40) {
    int settled = 0;
    for (int i = 0; i < frames; ++i) {
      step();
      if (error() > 1.2) settled = i + 1;
    }
    return settled;
  }
  // As a factor, 1 or more, on grey.
  double error() const {
    Histogram histogram;
    for (int c = 0; c < kCameras; ++c) {
      add({pixels_[c].data(), kWidth, kHeight, kWidth}, histogram);
    }
    const double factor =
        correction(histogram, double(params_.mean_grey), double(params_.highlights));
    return std::max(factor, 1 / factor);
  }
  const ExposureSetting& setting() const { return exposures_.front(); }
  const ExposureSetting& taken() const { return taken_; }
  int commands() const { return commands_; }
  const std::vector<uint8_t>& pixels(int c) const { return pixels_[c]; }
  void light(double light) { sensor_.light = light; }

  double rate_rad_s = 0;

 private:
  static const ExposureSetting& at(const std::deque<ExposureSetting>& settings, int delay) {
    return settings[size_t(delay - 1)];
  }
  // The mean of the lamps' light over an exposure that begins at t.
  double flicker(double t_s, double exposure_s) const {
    if (sensor_.modulation == 0) return 1;
    const double w = 2 * kPi_ * sensor_.flicker_hz;
    const double phase = std::cos(w * t_s) - std::cos(w * (t_s + exposure_s));
    return 1 + sensor_.modulation * phase / (w * exposure_s);
  }
  void expose() {
    const double t_s = sensor_.period_s * frames_ + 0.0017;
    const double light =
        sensor_.light * scale_ * taken_.product() * flicker(t_s, taken_.exposure_s);
    for (int c = 0; c < kCameras; ++c) {
      for (size_t i = 0; i < pixels_[c].size(); ++i) {
        if (i / kWidth % kGrid_px != kGrid_px / 2) continue;  // nobody looks there
        double response = radiance_[c][i] * light;
        if (sensor_.gamma != 1) response = std::pow(response, 1 / sensor_.gamma);
        const double noise = sensor_.noise_grey * noise_[++noise_at_ % noise_.size()];
        const double grey = 255 * response + sensor_.black_grey + noise;
        pixels_[c][i] = uint8_t(std::clamp(std::lround(grey), 0l, 255l));
      }
    }
  }

  Sensor sensor_;
  ExposureParams params_;
  AutoExposure controller_;
  std::vector<double> noise_;
  size_t noise_at_ = 0;
  double scale_ = 1;
  std::vector<double> radiance_[kCameras];
  std::vector<uint8_t> pixels_[kCameras];
  std::deque<ExposureSetting> exposures_;  // newest first
  ExposureSetting taken_;
  int frames_ = 0, commands_ = 0;
};

struct Worst {
  int frames = 0;
  void note(int settled) { frames = std::max(frames, settled); }
};

// Every delay that sensors have, of exposure and gain alike and apart, told and untold.
template <class Try>
void with_every_delay(Try&& attempt) {
  for (const bool tells : {false, true}) {
    for (int exposure = 1; exposure <= 3; ++exposure) {
      for (int gain = 1; gain <= exposure; ++gain) {
        Sensor sensor;
        sensor.tells = tells;
        sensor.exposure_delay = exposure;
        sensor.gain_delay = gain;
        attempt(sensor);
      }
    }
  }
}

TEST(auto_exposure, settles_within_ten_frames_from_dark_and_bright) {
  for (const double light : {0.06, 0.2, 0.5, 2.0, 5.0, 20.0, 50.0}) {
    Worst told, untold;
    with_every_delay([&](Sensor sensor) {
      sensor.light = light;
      sensor.left.exposure_s = sensor.exposure_delay == 1 ? 0.012 : 0.002;
      Scene scene(sensor);
      const int settled = scene.settle();
      EXPECT_LE(settled, 10) << "light " << light << ", delay " << sensor.exposure_delay << " and "
                             << sensor.gain_delay << (sensor.tells ? ", told" : ", untold");
      (sensor.tells ? told : untold).note(settled);
    });
    std::printf("light %5.2f: settled after %d frames at most, told %d\n", light, untold.frames,
                told.frames);
  }
}

TEST(auto_exposure, settles_within_ten_frames_after_a_sudden_change) {
  for (const double change : {0.05, 0.1, 0.3, 0.6, 1.7, 3.0, 10.0, 20.0}) {
    Worst told, untold;
    with_every_delay([&](Sensor sensor) {
      Scene scene(sensor);
      ASSERT_LE(scene.settle(), 10);
      scene.light(change);
      const int settled = scene.settle();
      EXPECT_LE(settled, 10) << "change " << change << ", delay " << sensor.exposure_delay;
      (sensor.tells ? told : untold).note(settled);
    });
    std::printf("change %5.2f: settled after %d frames at most, told %d\n", change, untold.frames,
                told.frames);
  }
}

// Once settled nothing is commanded any more, or the light itself changes slowly (its beat).
TEST(auto_exposure, does_not_oscillate_under_flicker) {
  for (const double flicker_hz : {100.0, 120.0}) {
    for (const double rate_hz : {20.0, 25.0, 30.0, 50.0, 60.0}) {
      for (const double modulation : {0.3, 0.9}) {
        int most = 0;
        double widest = 1;
        for (const double light : {0.2, 1.0, 4.0, 12.0}) {
          with_every_delay([&](Sensor sensor) {
            if (sensor.gain_delay != sensor.exposure_delay) return;
            sensor.flicker_hz = flicker_hz;
            sensor.modulation = modulation;
            sensor.period_s = 1 / rate_hz;
            sensor.light = light;
            Scene scene(sensor);
            scene.run(60);
            const int before = scene.commands();
            double low = 1e9, high = 0;
            for (int i = 0; i < 90; ++i) {
              scene.step();
              low = std::min(low, scene.setting().product());
              high = std::max(high, scene.setting().product());
            }
            most = std::max(most, scene.commands() - before);
            widest = std::max(widest, high / low);
          });
        }
        std::printf(
            "%3.0f Hz, %.0f %%, at %2.0f frames/s: %d commands in 90 frames, product "
            "within a factor of %.3f\n",
            flicker_hz, 100 * modulation, rate_hz, most, widest);
        EXPECT_LE(most, 1);
        EXPECT_LE(widest, 1.25);
      }
    }
  }
}

TEST(auto_exposure, long_exposures_are_whole_periods_of_the_flicker) {
  Sensor sensor;
  sensor.light = 0.1;
  sensor.period_s = 0.05;
  for (const float mains_hz : {50.0f, 60.0f}) {
    ExposureParams params;
    params.mains_hz = mains_hz;
    Scene scene(sensor, params);
    EXPECT_LE(scene.settle(), 20) << "the period must be known, before exposure can be long";
    const double periods = scene.setting().exposure_s * 2 * double(mains_hz);
    EXPECT_NEAR(periods, std::round(periods), 2e-3);
    EXPECT_GE(periods, 1.99);
    EXPECT_GT(scene.setting().gain, 1);
  }
}

TEST(auto_exposure, exposure_gives_way_to_motion_and_comes_back) {
  Sensor sensor;
  sensor.light = 0.5;
  Scene scene(sensor);
  EXPECT_LE(scene.settle(), 10);
  EXPECT_NEAR(scene.setting().exposure_s, 0.008, 0.0015);
  EXPECT_EQ(scene.setting().gain, 1);
  scene.rate_rad_s = 4;
  EXPECT_LE(scene.settle(), 10);
  EXPECT_LE(scene.setting().exposure_s * 276 * 4, 3 * 1.25) << "blur";
  EXPECT_GT(scene.setting().gain, 2);
  scene.rate_rad_s = 0.05;
  scene.run(60);
  EXPECT_NEAR(scene.setting().exposure_s, 0.008, 0.0015);
  EXPECT_EQ(scene.setting().gain, 1);
}

TEST(auto_exposure, leaves_the_trigger_its_readout) {
  Sensor sensor;
  sensor.light = 0.02;
  ExposureParams params;
  params.mains_hz = 0;
  Scene scene(sensor, params);
  for (int i = 0; i < 60; ++i) {
    scene.step();
    EXPECT_LE(scene.setting().exposure_s, 1.0 / 60 - 0.005 + 1e-5);
  }
  EXPECT_GT(scene.setting().exposure_s, 0.011);
  EXPECT_EQ(scene.setting().gain, params.gain_max) << "too dark even so, and at rest";
  const int commands = scene.commands();
  scene.run(60);
  EXPECT_EQ(scene.commands(), commands);
}

// Steps of 0.1 ms, as UVC has them, where the light wants half of one; no gain.
TEST(auto_exposure, coarse_steps_make_no_limit_cycle) {
  for (const double light : {11.0, 16.3, 26.7, 60.0, 400.0}) {
    Sensor sensor;
    sensor.light = light;
    sensor.range = {{1e-4, 1}, {0.1, 1}, {1e-4, 0}};
    Scene scene(sensor);
    scene.run(20);
    const int commands = scene.commands();
    scene.run(100);
    EXPECT_EQ(scene.commands(), commands) << light;
  }
}

// A response that is not known makes it slower, never unstable.
TEST(auto_exposure, any_response_converges) {
  for (const double light : {0.1, 8.0}) {
    for (const double gamma : {1.0, 1.8, 2.2}) {
      Sensor sensor;
      sensor.light = light;
      sensor.gamma = gamma;
      Scene unknown(sensor);
      const int slow = unknown.settle(80);
      EXPECT_LE(slow, 40) << gamma;
      const int commands = unknown.commands();
      unknown.run(60);
      EXPECT_LE(unknown.commands() - commands, 1);
      ExposureParams params;
      params.gamma = float(gamma);
      Scene known(sensor, params);
      const int fast = known.settle();
      EXPECT_LE(fast, 10) << gamma;
      std::printf("light %.1f, gamma %.1f: %d frames, known %d\n", light, gamma, slow, fast);
    }
  }
}

TEST(auto_exposure, fixed_values_are_told_once) {
  Sensor sensor;
  sensor.light = 0.5;
  ExposureParams params;
  params.exposure_s = 0.002f;
  params.gain = 4;
  Scene scene(sensor, params);
  scene.run(50);
  EXPECT_EQ(scene.commands(), 1);
  EXPECT_NEAR(scene.setting().exposure_s, 0.002, 1e-6);
  EXPECT_EQ(scene.setting().gain, 4);
  params.gain = 0;
  Scene gain_alone(sensor, params);
  EXPECT_LE(gain_alone.settle(), 10) << "it is controlled by gain";
  EXPECT_NEAR(gain_alone.setting().exposure_s, 0.002, 1e-6);
}

// A lamp in a corner: less than the mean would have it, but not black.
TEST(brightness, highlights_count_more_and_missing_images_do_not) {
  std::vector<uint8_t> image(64 * 64, 90);
  const ImageView view = {image.data(), 64, 64, 64};
  Histogram plain;
  add(view, plain);
  EXPECT_EQ(plain.total, 16u);
  EXPECT_EQ(mean_of(plain), 90);
  EXPECT_NEAR(correction(plain, 90, 2), 1, 0.01);
  EXPECT_NEAR(correction(plain, 45, 2), 0.5, 0.01);
  std::fill(image.begin() + 64 * 8, image.begin() + 64 * 8 + 1, 255);
  Histogram lamp;  // 1 of 16
  add(view, lamp);
  EXPECT_EQ(lamp.count[255], 1u);
  const double factor = correction(lamp, 90, 2);
  EXPECT_LT(factor, correction(lamp, 90, 0) - 0.05);
  EXPECT_GT(factor, 0.5);
  EXPECT_EQ(correction(Histogram{}, 90, 2), 1);
}

}  // namespace
}  // namespace pirvs
