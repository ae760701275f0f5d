// The library libpirvs.so.0 as programs use it: the examples in three languages, the same bytes as
// a replay, live, its commands, what it refuses, no heap, and an interface that does not change.
// In      PIRVS_BUILD (default build): library/libpirvs.so.0, library/poses-c and poses-cc.
// Cost    15 s.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "board/library/pirvs.h"
#include "modules/calibration/calibration_text.h"
#include "tests/heap_guard.h"
#include "tests/programs.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/player.h"

namespace pirvs::systems {
namespace {

// The functions, by name, as a program has them that loads the library while it runs.
struct Api {
  void* const library = dlopen((build_folder() + "/library/libpirvs.so.0").c_str(), RTLD_NOW);
  template <class Function>
  Function* find(Function*, const char* name) const {
    return library != nullptr ? reinterpret_cast<Function*>(dlsym(library, name)) : nullptr;
  }
#define PIRVS_FUNCTION(function)               \
  decltype(&pirvs_##function) const function = \
      find(static_cast<decltype(&pirvs_##function)>(nullptr), "pirvs_" #function)
  PIRVS_FUNCTION(version);
  PIRVS_FUNCTION(last_error);
  PIRVS_FUNCTION(create);
  PIRVS_FUNCTION(start);
  PIRVS_FUNCTION(feed_imu);
  PIRVS_FUNCTION(feed_images);
  PIRVS_FUNCTION(next_pose);
  PIRVS_FUNCTION(next_news);
  PIRVS_FUNCTION(get_points);
  PIRVS_FUNCTION(get_state);
  PIRVS_FUNCTION(get_counter);
  PIRVS_FUNCTION(set_parameter);
  PIRVS_FUNCTION(reset);
  PIRVS_FUNCTION(set_pose);
  PIRVS_FUNCTION(save_map);
  PIRVS_FUNCTION(load_map);
  PIRVS_FUNCTION(stop);
  PIRVS_FUNCTION(destroy);
#undef PIRVS_FUNCTION
};

const Api& api() {
  static const Api api;
  if (api.library == nullptr) {
    ADD_FAILURE() << dlerror() << ": make BOARD=library";
    std::abort();
  }
  return api;
}

// One recording, on the disk and in memory, with the calibration that a device reads.
struct Flight {
  tools::Recording recording;
  std::string calibration;
  std::vector<std::vector<uint8_t>> pixels;
  std::vector<pirvs_images> images;

  Flight() {
    tools::SimOptions options;
    options.duration_s = 5;
    options.rest_s = 0.5;
    options.blur = 2;
    options.format = "pgm";
    recording = made(options, "library");
    calibration = recording.folder + "/calibration.cfg";
    Text<kCalibrationTextMax> text;
    write_calibration(recording.calibration, text);
    std::ofstream(calibration) << text.c_str();
    tools::RecordingOptions as_device;
    as_device.calibration = calibration;
    recording = tools::open_recording(recording.folder, as_device);
    tools::Player player(recording);
    while (const StereoFrame* const frame = player.next()) {
      pirvs_images out = {};
      out.size = sizeof out;
      out.t_ns = frame->t;
      for (int c = 0; c < 2; ++c) {
        const ImageView& image = frame->image[c];
        pixels.emplace_back(image.data, image.data + image.height * image.stride);
        out.image[c] = pixels.back().data();
        out.stride = static_cast<uint32_t>(image.stride);
      }
      images.push_back(out);
      player.release(frame);
    }
  }
};

const Flight& flight() {
  static const Flight flight;
  return flight;
}

pirvs_imu imu_of(const ImuSample& sample) {
  pirvs_imu out = {};
  out.size = sizeof out;
  out.t_ns = sample.t;
  for (int i = 0; i < 3; ++i) out.w_rad_s[i] = sample.w_B[i], out.f_m_s2[i] = sample.f_B[i];
  return out;
}

template <class T>
T sized() {
  T out = {};
  out.size = sizeof out;
  return out;
}

pirvs_config config_of(uint32_t mode) {
  auto out = sized<pirvs_config>();
  out.mode = mode;
  out.calibration = flight().calibration.c_str();
  return out;
}

pirvs_slam* created(const pirvs_config& config) {
  pirvs_slam* slam = nullptr;
  EXPECT_EQ(api().create(&config, &slam), PIRVS_OK) << api().last_error();
  EXPECT_EQ(api().start(slam), PIRVS_OK) << api().last_error();
  return slam;
}

struct Heard {
  int poses = 0, frames = 0, news = 0;
  pirvs_pose last = {};
};

void listen(pirvs_config& config, Heard& heard) {
  config.context = &heard;
  config.on_pose = [](void* to, const pirvs_pose* pose) {
    ++static_cast<Heard*>(to)->poses;
    static_cast<Heard*>(to)->last = *pose;
  };
  config.on_frame = [](void* to, const pirvs_pose*) { ++static_cast<Heard*>(to)->frames; };
  config.on_news = [](void* to, const pirvs_news*) { ++static_cast<Heard*>(to)->news; };
}

// In order of time; real_time: each when it is due, and not taken where the machine is too slow.
// `each` after every sample.
template <class Each>
void feed(pirvs_slam* slam, bool real_time, Each&& each) {
  const auto begin = std::chrono::steady_clock::now();
  const TimeNs begin_t = flight().recording.imu.front().t;
  const auto taken = [real_time](pirvs_status status) {
    return status == PIRVS_OK || (real_time && status == PIRVS_FULL);
  };
  size_t frame = 0;
  for (const ImuSample& sample : flight().recording.imu) {
    for (; frame < flight().images.size() && flight().images[frame].t_ns < sample.t; ++frame) {
      EXPECT_TRUE(taken(api().feed_images(slam, &flight().images[frame])));
    }
    if (real_time) {
      std::this_thread::sleep_until(begin + std::chrono::nanoseconds(sample.t - begin_t));
    }
    const pirvs_imu imu = imu_of(sample);
    EXPECT_TRUE(taken(api().feed_imu(slam, &imu)));
    each();
  }
}

std::string tum(const pirvs_pose& pose) {
  const Vec3 p(pose.p_m[0], pose.p_m[1], pose.p_m[2]);
  const Vec4 q(pose.q_xyzw[0], pose.q_xyzw[1], pose.q_xyzw[2], pose.q_xyzw[3]);
  return tools::tum_line(pose.t_ns, p, q);
}

TEST(library, examples_in_three_languages_agree_with_a_replay) {
  const std::string expected = replay(flight().recording).trajectory();
  EXPECT_GT(std::count(expected.begin(), expected.end(), '\n'), 60);
  const std::string library = build_folder() + "/library";
  const std::string arguments = " " + flight().recording.folder + "/mav0 " + flight().calibration;
  EXPECT_EQ(said_by(library + "/poses-c" + arguments), expected);
  EXPECT_EQ(said_by(library + "/poses-cc" + arguments), expected);
  EXPECT_EQ(said_by("LD_LIBRARY_PATH=" + library + " python3 board/library/examples/poses.py" +
                    arguments),
            expected);
}

TEST(library, stepped_gives_the_bytes_of_a_replay_without_heap) {
  const std::string expected = replay(flight().recording).trajectory();
  Heard heard;
  pirvs_config config = config_of(PIRVS_STEPPED);
  config.points = 1;
  listen(config, heard);
  pirvs_slam* const slam = created(config);
  std::string trajectory;
  trajectory.reserve(1 << 20);
  std::vector<pirvs_pose> taken;
  taken.reserve(1000);
  int at_imu = 0, clouds = 0, most = 0;
  static pirvs_point point[1000];
  {
    const HeapGuard guard;
    feed(slam, false, [&] {
      auto pose = sized<pirvs_pose>();
      while (api().next_pose(slam, PIRVS_AT_FRAME, &pose) == PIRVS_OK) taken.push_back(pose);
      while (api().next_pose(slam, PIRVS_AT_IMU, &pose) == PIRVS_OK) ++at_imu;
      auto points = sized<pirvs_points>();
      points.point_size = sizeof(pirvs_point);
      points.point = point;
      points.max = 1000;
      if (api().get_points(slam, &points) != PIRVS_OK) return;
      ++clouds;
      most = std::max(most, static_cast<int>(points.count));
    });
    EXPECT_EQ(api().stop(slam), PIRVS_OK) << api().last_error();
  }
  EXPECT_EQ(HeapGuard::calls(), 0u);
  if (HeapGuard::calls() > 0) HeapGuard::print_first();
  auto pose = sized<pirvs_pose>();
  while (api().next_pose(slam, PIRVS_AT_FRAME, &pose) == PIRVS_OK) taken.push_back(pose);
  for (const pirvs_pose& one : taken) trajectory += tum(one);
  EXPECT_EQ(trajectory, expected);
  EXPECT_EQ(heard.frames, static_cast<int>(taken.size()));
  EXPECT_EQ(heard.poses, at_imu);
  EXPECT_GT(at_imu, 700);
  EXPECT_GT(clouds, 80);
  EXPECT_GT(most, 50);
  EXPECT_GE(heard.news, 1);
  auto news = sized<pirvs_news>();
  EXPECT_EQ(api().next_news(slam, &news), PIRVS_OK);
  EXPECT_GT(std::strlen(news.text), 3u);
  auto state = sized<pirvs_state>();
  EXPECT_EQ(api().get_state(slam, &state), PIRVS_OK);
  EXPECT_EQ(state.imu_fed, flight().recording.imu.size());
  EXPECT_EQ(state.images_fed, flight().images.size());
  EXPECT_EQ(state.imu_lost + state.images_lost + state.poses_lost + state.frames_lost, 0u);
  EXPECT_EQ(state.health, static_cast<uint32_t>(PIRVS_TRACKING));
  EXPECT_EQ(state.running, 0u);
  const char* name = nullptr;
  uint64_t value = 0;
  std::set<std::string> names;
  for (int i = 0; api().get_counter(slam, i, &name, &value) == PIRVS_OK; ++i) names.insert(name);
  EXPECT_EQ(names.count("frames_with_pose"), 1u);
  api().destroy(slam);
}

TEST(library, lives_on_threads_of_its_own_without_heap) {
  Heard heard;
  pirvs_config config = config_of(PIRVS_LIVE);
  const std::string folder = scratch_folder("library_maps");
  config.folder = folder.c_str();
  listen(config, heard);
  pirvs_slam* const slam = created(config);
  int at_frame = 0, samples = 0;
  pirvs_status saved = PIRVS_EMPTY, moved = PIRVS_EMPTY, tuned = PIRVS_EMPTY, wrong = PIRVS_EMPTY;
  auto pose = sized<pirvs_pose>();
  const double place[3] = {10, 20, 30};
  {
    const HeapGuard guard;
    feed(slam, true, [&] {
      while (api().next_pose(slam, PIRVS_AT_FRAME, &pose) == PIRVS_OK) ++at_frame;
      if (++samples == 700) saved = api().save_map(slam, "room.map");
      if (samples == 800) moved = api().set_pose(slam, place, 0.5, 0);
      if (samples == 850) tuned = api().set_parameter(slam, "tracker.misses_max", 4);
      if (samples == 860) wrong = api().set_parameter(slam, "tracker.nothing", 4);
    });
    EXPECT_EQ(api().stop(slam), PIRVS_OK) << api().last_error();
  }
  EXPECT_EQ(HeapGuard::calls(), 0u);
  if (HeapGuard::calls() > 0) HeapGuard::print_first();
  EXPECT_EQ(saved, PIRVS_OK);
  EXPECT_EQ(moved, PIRVS_OK);
  EXPECT_EQ(tuned, PIRVS_OK);
  EXPECT_EQ(wrong, PIRVS_NOT_FOUND);
  EXPECT_GT(at_frame, 20);
  EXPECT_GT(heard.poses, 300);
  EXPECT_NEAR(heard.last.p_m[0], 10, 5);
  EXPECT_NEAR(heard.last.p_m[2], 30, 5);
  EXPECT_GE(heard.last.resets, 1u);
  EXPECT_EQ(api().feed_imu(slam, nullptr), PIRVS_BAD_ARGUMENT);
  api().destroy(slam);

  // Another day, from that map on.
  pirvs_config again = config_of(PIRVS_STEPPED);
  again.folder = folder.c_str();
  pirvs_slam* const next = created(again);
  EXPECT_EQ(api().load_map(next, "none.map"), PIRVS_NOT_FOUND);
  EXPECT_EQ(api().load_map(next, "room.map"), PIRVS_OK) << api().last_error();
  feed(next, false, [] {});
  auto state = sized<pirvs_state>();
  EXPECT_EQ(api().get_state(next, &state), PIRVS_OK);
  EXPECT_EQ(state.localised, 1u);
  EXPECT_EQ(api().reset(next), PIRVS_OK);
  EXPECT_EQ(api().stop(next), PIRVS_BAD_DATA) << "nothing was tracked since";
  api().destroy(next);
}

TEST(library, what_cannot_be_taken_is_counted) {
  pirvs_slam* const slam = created(config_of(PIRVS_LIVE));
  // Far more than wait, faster than any stack takes them.
  uint64_t full = 0;
  for (int64_t i = 0; i < 20'000; ++i) {
    ImuSample sample;
    sample.t = 1'000'000'000 + i * 5'000'000;
    sample.f_B = Vec3(0.01 * static_cast<double>(i % 7), 0, 9.81);
    const pirvs_imu imu = imu_of(sample);
    const pirvs_status status = api().feed_imu(slam, &imu);
    EXPECT_TRUE(status == PIRVS_OK || status == PIRVS_FULL);
    full += status == PIRVS_FULL ? 1 : 0;
  }
  auto state = sized<pirvs_state>();
  EXPECT_EQ(api().get_state(slam, &state), PIRVS_OK);
  EXPECT_GT(full, 1000u);
  EXPECT_EQ(state.imu_lost, full);
  EXPECT_EQ(state.imu_fed, 20'000 - full);
  EXPECT_EQ(api().stop(slam), PIRVS_BAD_DATA);
  EXPECT_STREQ(api().last_error(), "tracking found no start");
  api().destroy(slam);
}

TEST(library, refuses_what_makes_no_sense_with_a_reason) {
  pirvs_slam* slam = nullptr;
  pirvs_config config = config_of(PIRVS_STEPPED);
  EXPECT_EQ(api().create(nullptr, &slam), PIRVS_BAD_ARGUMENT);
  EXPECT_EQ(api().create(&config, nullptr), PIRVS_BAD_ARGUMENT);
  config.size = 8;
  EXPECT_EQ(api().create(&config, &slam), PIRVS_BAD_ARGUMENT);
  config.size = sizeof config;
  config.mode = 2;
  EXPECT_EQ(api().create(&config, &slam), PIRVS_BAD_ARGUMENT);
  config.mode = PIRVS_STEPPED;
  config.calibration = "/nowhere/calibration.cfg";
  EXPECT_EQ(api().create(&config, &slam), PIRVS_NOT_FOUND);
  EXPECT_NE(std::string(api().last_error()).find("/nowhere/calibration.cfg: "), std::string::npos);
  const std::string broken = scratch_folder("library_broken") + "/calibration.cfg";
  std::ofstream(broken) << "cameras = 2\ncam0.model = fish\n";
  config.calibration = broken.c_str();
  EXPECT_EQ(api().create(&config, &slam), PIRVS_BAD_DATA);
  EXPECT_NE(std::string(api().last_error()).find(":2: "), std::string::npos) << api().last_error();
  EXPECT_EQ(slam, nullptr);
  api().destroy(nullptr);
  EXPECT_EQ(api().start(nullptr), PIRVS_BAD_ARGUMENT);

  config = config_of(PIRVS_STEPPED);
  ASSERT_EQ(api().create(&config, &slam), PIRVS_OK);
  pirvs_slam* second = nullptr;
  EXPECT_EQ(api().create(&config, &second), PIRVS_REFUSED) << "one in a process";
  const pirvs_imu imu = imu_of(flight().recording.imu.front());
  EXPECT_EQ(api().feed_imu(slam, &imu), PIRVS_REFUSED) << "not started";
  EXPECT_EQ(api().reset(slam), PIRVS_REFUSED);
  EXPECT_EQ(api().set_parameter(slam, "nothing", 1), PIRVS_NOT_FOUND);
  EXPECT_EQ(api().set_parameter(slam, "tracker.misses_max", -1), PIRVS_BAD_ARGUMENT);
  EXPECT_EQ(api().set_parameter(slam, "tracker.misses_max", 3), PIRVS_OK);
  EXPECT_EQ(api().start(slam), PIRVS_OK);
  EXPECT_EQ(api().start(slam), PIRVS_REFUSED) << "twice";
  EXPECT_EQ(api().save_map(slam, nullptr), PIRVS_BAD_ARGUMENT);
  EXPECT_EQ(api().save_map(slam, std::string(64, 'x').c_str()), PIRVS_BAD_ARGUMENT);
  auto pose = sized<pirvs_pose>();
  EXPECT_EQ(api().next_pose(slam, 7, &pose), PIRVS_BAD_ARGUMENT);
  EXPECT_EQ(api().next_pose(slam, PIRVS_AT_IMU, &pose), PIRVS_EMPTY);
  auto points = sized<pirvs_points>();
  points.point_size = sizeof(pirvs_point);
  EXPECT_EQ(api().get_points(slam, &points), PIRVS_REFUSED) << "not asked for";
  api().destroy(slam);
  EXPECT_EQ(api().stop(slam), PIRVS_BAD_ARGUMENT) << "destroyed";
  EXPECT_GT(std::strlen(api().version()), 2u);
}

TEST(library, calls_from_a_callback_are_refused_and_newer_headers_are_served) {
  struct Inside {
    pirvs_slam* slam = nullptr;
    pirvs_status reset = PIRVS_OK, feed = PIRVS_OK, stop = PIRVS_OK;
  } inside;
  pirvs_config config = config_of(PIRVS_STEPPED);
  config.context = &inside;
  config.on_frame = [](void* to, const pirvs_pose*) {
    auto& self = *static_cast<Inside*>(to);
    const pirvs_imu imu = imu_of(flight().recording.imu.front());
    self.reset = api().reset(self.slam);
    self.feed = api().feed_imu(self.slam, &imu);
    self.stop = api().stop(self.slam);
  };
  inside.slam = created(config);
  // What a program has that was built with a later header.
  struct {
    pirvs_pose known;
    uint64_t later;
  } pose = {{}, 77};
  pose.known.size = sizeof pose;
  int poses = 0;
  feed(inside.slam, false, [&] {
    while (api().next_pose(inside.slam, PIRVS_AT_IMU, &pose.known) == PIRVS_OK) ++poses;
  });
  EXPECT_GT(poses, 600);
  EXPECT_EQ(pose.known.size, sizeof pose);
  EXPECT_EQ(pose.later, 77u);
  EXPECT_EQ(inside.reset, PIRVS_REFUSED);
  EXPECT_EQ(inside.feed, PIRVS_REFUSED);
  EXPECT_EQ(inside.stop, PIRVS_REFUSED);
  api().destroy(inside.slam);
}

// Where programs that were built find the fields. Another place breaks them: libpirvs.so.1.
#define PIRVS_AT(type, field, offset) static_assert(offsetof(type, field) == (offset))
PIRVS_AT(pirvs_pose, health, 4);
PIRVS_AT(pirvs_pose, t_ns, 8);
PIRVS_AT(pirvs_pose, t_frame_ns, 16);
PIRVS_AT(pirvs_pose, p_m, 24);
PIRVS_AT(pirvs_pose, q_xyzw, 48);
PIRVS_AT(pirvs_pose, v_m_s, 80);
PIRVS_AT(pirvs_pose, w_rad_s, 104);
PIRVS_AT(pirvs_pose, cov, 128);
PIRVS_AT(pirvs_pose, confidence, 776);
PIRVS_AT(pirvs_pose, reasons, 780);
PIRVS_AT(pirvs_pose, resets, 784);
PIRVS_AT(pirvs_pose, jump_m, 788);
PIRVS_AT(pirvs_pose, jump_rad, 792);
PIRVS_AT(pirvs_pose, epoch, 796);
PIRVS_AT(pirvs_pose, in_map, 800);
PIRVS_AT(pirvs_pose, dead_reckoning, 804);
PIRVS_AT(pirvs_news, health, 4);
PIRVS_AT(pirvs_news, t_ns, 8);
PIRVS_AT(pirvs_news, text, 16);
PIRVS_AT(pirvs_config, mode, 4);
PIRVS_AT(pirvs_config, calibration, 8);
PIRVS_AT(pirvs_config, folder, 16);
PIRVS_AT(pirvs_config, cores, 24);
PIRVS_AT(pirvs_config, mono, 28);
PIRVS_AT(pirvs_config, monotonic, 32);
PIRVS_AT(pirvs_config, points, 36);
PIRVS_AT(pirvs_config, context, 40);
PIRVS_AT(pirvs_config, on_pose, 48);
PIRVS_AT(pirvs_config, on_frame, 56);
PIRVS_AT(pirvs_config, on_news, 64);
PIRVS_AT(pirvs_imu, t_ns, 8);
PIRVS_AT(pirvs_imu, w_rad_s, 16);
PIRVS_AT(pirvs_imu, f_m_s2, 40);
PIRVS_AT(pirvs_images, stride, 4);
PIRVS_AT(pirvs_images, t_ns, 8);
PIRVS_AT(pirvs_images, image, 16);
PIRVS_AT(pirvs_point, p_m, 8);
PIRVS_AT(pirvs_point, sigma_m, 32);
PIRVS_AT(pirvs_points, point_size, 4);
PIRVS_AT(pirvs_points, point, 8);
PIRVS_AT(pirvs_points, max, 16);
PIRVS_AT(pirvs_points, count, 20);
PIRVS_AT(pirvs_points, t_ns, 24);
PIRVS_AT(pirvs_state, health, 4);
PIRVS_AT(pirvs_state, running, 8);
PIRVS_AT(pirvs_state, localised, 12);
PIRVS_AT(pirvs_state, confidence, 16);
PIRVS_AT(pirvs_state, reasons, 20);
PIRVS_AT(pirvs_state, imu_fed, 24);
PIRVS_AT(pirvs_state, poses_lost, 56);
PIRVS_AT(pirvs_state, imu_to_pose_ms, 72);
#undef PIRVS_AT

TEST(library, exports_what_programs_were_built_with) {
  std::set<std::string> stored, exported;
  std::ifstream symbols("tools/deb/libpirvs0.symbols");
  std::string name;
  std::getline(symbols, name);
  for (std::string line; std::getline(symbols, line);) {
    std::istringstream(line) >> name;
    stored.insert(name);
  }
  std::istringstream listed(
      said_by("nm -D --defined-only " + build_folder() + "/library/libpirvs.so.0"));
  for (std::string line; std::getline(listed, line);) {
    name = line.substr(line.rfind(' ') + 1);
    const size_t at = name.find("@@");
    exported.insert(at == std::string::npos ? name + "@" + name : name.erase(at, 1));
  }
  EXPECT_EQ(exported, stored) << "tools/deb/libpirvs0.symbols: what is gone breaks programs";
}

}  // namespace
}  // namespace pirvs::systems
