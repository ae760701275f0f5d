// Long file: one fixture lives with an App in every way that the tests here do.
#include "modules/app/app.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "bsp/api/clock.h"
#include "bsp/linux/storage.h"
#include "bsp/replay/sensors.h"
#include "modules/app/replay_pace.h"

namespace pirvs {
namespace {

constexpr int kWidth = 320, kHeight = 240, kDisparity = 12;
constexpr TimeNs kBegin = 1'000'000'000'000;
constexpr TimeNs kImu_ns = 5'000'000, kFrame_ns = 50'000'000;

// A device that rests before a textured wall, played by bsp/replay. Noise makes each image and each
// sample another, as real ones are.
class Still {
 public:
  explicit Still(int frames) : frames_(frames) {
    std::mt19937 random(7);
    std::vector<int> coarse((kWidth / 4 + 8) * (kHeight / 4));
    for (int& grey : coarse) grey = int(random() % 200) + 20;
    for (int c = 0; c < kCamerasMax; ++c) {
      scene_[c].resize(kWidth * kHeight);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          // Two planes: a map of one alone is not recognised (Places::found_is_planar).
          const int disparity = y < kHeight / 2 ? kDisparity : 2 * kDisparity;
          const int column = (x + c * disparity) / 4, row = y / 4;
          scene_[c][size_t(y * kWidth + x)] =
              uint8_t(coarse[size_t(row * (kWidth / 4 + 8) + column)]);
        }
      }
      for (auto& slot : pixels_) slot[c] = scene_[c];
    }
  }

  static Calibration calibration() {
    Calibration out;
    for (int c = 0; c < kCamerasMax; ++c) {
      Camera& camera = out.camera[c];
      camera.width = kWidth;
      camera.height = kHeight;
      camera.fx = camera.fy = 200;
      camera.cx = kWidth / 2.0;
      camera.cy = kHeight / 2.0;
      camera.T_BC.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
      camera.T_BC.p = Vec3(0, c == 0 ? 0.05 : -0.05, 0);
    }
    return out;
  }

  bsp::RecordingSource source() {
    return {this, next_imu, next_frame, [](void*, FrameId) {}};
  }

 private:
  static bool next_imu(void* context, ImuSample& out) {
    Still& s = *static_cast<Still*>(context);
    if (s.imu_at_ * kImu_ns > s.frames_ * kFrame_ns) return false;
    out = ImuSample{};
    out.t = kBegin + s.imu_at_++ * kImu_ns;
    std::normal_distribution<double> noise(0, 1);
    for (int i = 0; i < 3; ++i) out.w_B[i] = 2e-3 * noise(s.random_);
    for (int i = 0; i < 3; ++i) out.f_B[i] = 2e-2 * noise(s.random_);
    out.f_B.z() += 9.81;
    return true;
  }
  static bool next_frame(void* context, StereoFrame& out) {
    Still& s = *static_cast<Still*>(context);
    if (s.frame_at_ == s.frames_) return false;
    out = StereoFrame{};
    out.t = kBegin + s.frame_at_++ * kFrame_ns;
    out.present = 3;
    auto& pixels = s.pixels_[size_t(s.frame_at_) % bsp::kReplayFrames];
    for (int c = 0; c < kCamerasMax; ++c) {
      for (size_t i = 0; i < pixels[c].size(); ++i) {
        pixels[c][i] = uint8_t(s.scene_[c][i] + s.random_() % 3);
      }
      out.image[c] = {pixels[c].data(), kWidth, kHeight, kWidth};
    }
    return true;
  }

  TimeNs frames_, imu_at_ = 0, frame_at_ = 0;
  std::mt19937 random_{3};
  std::vector<uint8_t> scene_[kCamerasMax];
  std::vector<uint8_t> pixels_[bsp::kReplayFrames][kCamerasMax];  // a slot of the lender each
};

struct Log {
  std::atomic<int> frames{0}, poses{0};
  std::vector<Answer> answers;
  std::vector<BodyState> states;
  std::vector<std::string> health;
  uint32_t resets = 0;
  std::vector<const char*> folders;  // for recordings, the next one last

  AppSinks sinks() {
    AppSinks sinks;
    sinks.context = this;
    sinks.frame = [](void* log, const FrameReport& report) {
      Log& self = *static_cast<Log*>(log);
      ++self.frames;
      self.poses += report.has_pose ? 1 : 0;
      if (report.has_pose) self.states.push_back(report.pose.state);
      self.resets = report.pose.trust.resets;
    };
    sinks.health = [](void* log, TimeNs, HealthState, const char* what) {
      static_cast<Log*>(log)->health.push_back(what);
    };
    sinks.answer = [](void* log, const Answer& answer) {
      static_cast<Log*>(log)->answers.push_back(answer);
    };
    sinks.new_recording = [](void* log) -> Result<const char*> {
      std::vector<const char*>& left = static_cast<Log*>(log)->folders;
      if (left.empty()) return Status::kFull;
      const char* const folder = left.back();
      left.pop_back();
      return folder;
    };
    return sinks;
  }
};

class AppLife : public testing::Test {
 protected:
  AppLife() : app_(std::make_unique<App>()) {}

  void play_fast(Still& still) {
    app_->configure(Still::calibration(), AppParams{}, log_.sinks());
    bsp::play(still.source(), bsp::ReplayPace::kFast);
    app_->pace(lockstep_may_go_on);
  }
  static Command command(CommandKind kind) {
    Command out;
    out.kind = kind;
    return out;
  }

  Log log_;
  std::unique_ptr<App> app_;
};

constexpr CorePlan kOneCore = {1, 0, 0, 0, 0, 0};
constexpr CorePlan kTwoCores = {2, 0, 0, 1, 0, 1};
constexpr CorePlan kThreeCores = {3, 0, 0, 1, 0, 2};

TEST_F(AppLife, RunsToTheEndOfTheSensors) {
  Still still(40);
  play_fast(still);
  EXPECT_EQ(app_->run(kOneCore, Drive::kLockstep), Status::kOk);
  EXPECT_EQ(log_.frames, 40);
  EXPECT_GT(log_.poses, 20);
}

TEST_F(AppLife, StepsOneByOneAndEndsWithStale) {
  Still still(40);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  int steps = 0;
  while (app_->poll() == Status::kOk) ++steps;
  EXPECT_EQ(app_->poll(), Status::kStale);
  EXPECT_EQ(app_->finish(), Status::kOk);
  EXPECT_GT(steps, 100);
  EXPECT_EQ(log_.frames, 40);
}

TEST_F(AppLife, StopsInOrderWhenToldTo) {
  Still still(40);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 30) ASSERT_EQ(app_->poll(), Status::kOk);
  const Result<uint32_t> ticket = app_->command(command(CommandKind::kStop));
  ASSERT_TRUE(ticket.ok());
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  ASSERT_EQ(log_.answers.size(), 1u);
  EXPECT_EQ(log_.answers[0].ticket, ticket.value());
  EXPECT_EQ(log_.answers[0].status, Status::kOk);
  EXPECT_LE(log_.frames, 32) << "the frame in work is the last";
  EXPECT_GT(app_->map().landmarks.size(), 20u);
}

TEST_F(AppLife, StartsAnewAfterAReset) {
  Still still(80);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 40) ASSERT_EQ(app_->poll(), Status::kOk);
  const int poses = log_.poses;
  const uint32_t resets = log_.resets;
  ASSERT_GT(poses, 0);
  ASSERT_TRUE(app_->command(command(CommandKind::kReset)).ok());
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  EXPECT_GT(log_.poses, poses + 10);
  EXPECT_LT(log_.poses, 80 - (40 - poses)) << "a start takes time again";
  EXPECT_GT(log_.resets, resets) << "a consumer must see that the pose may have jumped";
}

TEST_F(AppLife, AnswersWhatItCannotDo) {
  Still still(40);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  ASSERT_TRUE(app_->command(command(CommandKind::kStopRecording)).ok());
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  ASSERT_EQ(log_.answers.size(), 1u);
  EXPECT_EQ(log_.answers[0].kind, CommandKind::kStopRecording);
  EXPECT_EQ(log_.answers[0].status, Status::kStale) << "nothing is recorded";
}

uint64_t counter(const App& app, const char* name) {
  NamedValue values[256];
  const int count = app.counters(values, 256);
  for (int i = 0; i < count; ++i) {
    if (std::strcmp(values[i].name, name) == 0) return values[i].value;
  }
  ADD_FAILURE() << name;
  return 0;
}

TEST_F(AppLife, CountsOnOverAReset) {
  constexpr const char* kCounted[] = {"frames",       "frames_with_pose",  "starts",
                                      "keyframes",    "mapping_keyframes", "adjustments",
                                      "stereo_found", "gate_accepted"};
  Still still(80);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 40) ASSERT_EQ(app_->poll(), Status::kOk);
  std::vector<uint64_t> before;
  for (const char* name : kCounted) before.push_back(counter(*app_, name));
  ASSERT_TRUE(app_->command(command(CommandKind::kReset)).ok());
  while (log_.answers.empty()) ASSERT_EQ(app_->poll(), Status::kOk);
  for (size_t i = 0; i < std::size(kCounted); ++i) {
    EXPECT_GT(before[i], 0u) << kCounted[i];
    EXPECT_GE(counter(*app_, kCounted[i]), before[i]) << kCounted[i];
  }
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  EXPECT_EQ(counter(*app_, "frames"), 80u);
  EXPECT_EQ(counter(*app_, "starts"), 2u);
}

TEST_F(AppLife, TakesWhatIsDelivered) {
  Still still(40);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 20) ASSERT_EQ(app_->poll(), Status::kOk);
  GnssFix fix;
  fix.t = INT64_MAX;
  EXPECT_EQ(app_->deliver(arrival_of(fix)), Status::kOk);
  EXPECT_EQ(app_->deliver(arrival_of(bsp::GpioEdge{kBegin, {1, 2}, true}, true)), Status::kOk);
  EXPECT_EQ(app_->deliver(arrival_of(ArrivalKind::kLost, Sensor::kCamera)), Status::kOk);
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  EXPECT_EQ(counter(*app_, "aside_stamp_impossible"), 1u);
  EXPECT_EQ(counter(*app_, "edges_lost"), 1u);
  EXPECT_EQ(counter(*app_, "camera_lost_device"), 1u);
  EXPECT_EQ(counter(*app_, "camera_back"), 1u) << "its next frame says so";
  EXPECT_EQ(std::count(log_.health.begin(), log_.health.end(), "the cameras are lost"), 1);
  EXPECT_EQ(std::count(log_.health.begin(), log_.health.end(), "the cameras are back"), 1);
}

// Whatever is commanded, done or refused, is no frame.
TEST_F(AppLife, MeasuresTheLatencyOfFramesAlone) {
  Still still(60);
  play_fast(still);
  app_->set_clock([] { return kBegin; });
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 30) ASSERT_EQ(app_->poll(), Status::kOk);
  for (const CommandKind kind :
       {CommandKind::kSetParameter, CommandKind::kLoadMap, CommandKind::kSetPose}) {
    ASSERT_TRUE(app_->command(command(kind)).ok());
  }
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  ASSERT_EQ(log_.answers.size(), 3u);
  EXPECT_GT(log_.poses, 30);
  EXPECT_EQ(app_->latency().exposure_to_fused.summary().count, uint64_t(log_.poses));
}

TEST_F(AppLife, SetsAParameterWhileItTracks) {
  Still still(60);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 30) ASSERT_EQ(app_->poll(), Status::kOk);
  struct {
    const char* name;
    float value;
    Status answer;
  } const cases[] = {{"frontend.tracks_target", 60, Status::kOk},
                     {"tracks_wanted", 60, Status::kNotFound},
                     {"sigma_px", 1, Status::kNotFound},
                     {"frontend.tracks_target", 1e6f, Status::kBadData},
                     {"mapping.window", 5.5f, Status::kBadData},
                     {"door.bridge_s", 0.7f, Status::kStale}};
  for (const auto& c : cases) {
    Command set = command(CommandKind::kSetParameter);
    std::strcpy(set.text, c.name);
    set.value = c.value;
    ASSERT_TRUE(app_->command(set).ok());
  }
  const int poses = log_.poses;
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  ASSERT_EQ(log_.answers.size(), std::size(cases));
  for (size_t i = 0; i < std::size(cases); ++i) {
    EXPECT_EQ(log_.answers[i].status, cases[i].answer) << cases[i].name;
  }
  EXPECT_GE(log_.poses, poses + 29) << "tracking goes on";
  EXPECT_EQ(counter(*app_, "starts"), 1u);
}

// A camera that says what it was told, and whose images stay as they are.
struct Obedient {
  Still still{60};
  std::vector<CameraControl> told;
  bool deaf = false;

  bsp::RecordingSource source() {
    bsp::RecordingSource out = still.source();
    out.context = this;
    out.next_imu = [](void* c, ImuSample& sample) { return self(c).next_imu(sample); };
    out.next_frame = [](void* c, StereoFrame& frame) { return self(c).next_frame(frame); };
    out.range = [](void*) -> Result<CameraRange> {
      CameraRange range;
      range.exposure_ns_min = 20'000;
      range.exposure_ns_max = 30'000'000;
      range.gain_max = 16;
      return range;
    };
    out.control = [](void* c, const CameraControl& control) {
      self(c).told.push_back(control);
      return self(c).deaf ? Status::kNotFound : Status::kOk;
    };
    return out;
  }
  static Obedient& self(void* c) { return *static_cast<Obedient*>(c); }
  bool next_imu(ImuSample& out) { return still.source().next_imu(&still, out); }
  bool next_frame(StereoFrame& out) {
    if (!still.source().next_frame(&still, out)) return false;
    for (ImageInfo& info : out.info) {
      if (!told.empty()) info = {told.back().exposure_ns, told.back().gain, 0};
    }
    return true;
  }
};

TEST_F(AppLife, TellsLiveCamerasTheirExposure) {
  Obedient cameras;
  AppParams params;
  params.exposure.mean_grey = 160;
  params.exposure.highlights = 0;
  app_->configure(Still::calibration(), params, log_.sinks());
  bsp::play(cameras.source(), bsp::ReplayPace::kFast);
  ASSERT_EQ(app_->start(kOneCore, Drive::kTimed), Status::kOk);
  while (app_->poll() != Status::kStale) {
  }
  (void)app_->finish();
  ASSERT_GE(cameras.told.size(), 3u);
  EXPECT_GT(cameras.told.back().gain, 1) << "the images stay dark, whatever is told";
  EXPECT_EQ(
      std::count(log_.health.begin(), log_.health.end(), "the cameras take no exposure and gain"),
      0);
}

TEST_F(AppLife, SaysOnceThatCamerasTakeNoExposure) {
  Obedient cameras;
  cameras.deaf = true;
  app_->configure(Still::calibration(), AppParams{}, log_.sinks());
  bsp::play(cameras.source(), bsp::ReplayPace::kFast);
  ASSERT_EQ(app_->start(kOneCore, Drive::kTimed), Status::kOk);
  while (app_->poll() != Status::kStale) {
  }
  (void)app_->finish();
  EXPECT_EQ(cameras.told.size(), 1u);
  EXPECT_EQ(
      std::count(log_.health.begin(), log_.health.end(), "the cameras take no exposure and gain"),
      1);
}

TEST_F(AppLife, AReplayOrWhoeverAsksForNoneLeavesExposureAlone) {
  Obedient cameras;
  play_fast(cameras.still);
  bsp::play(cameras.source(), bsp::ReplayPace::kFast);
  EXPECT_EQ(app_->run(kOneCore, Drive::kLockstep), Status::kOk);
  EXPECT_TRUE(cameras.told.empty());
  Obedient others;
  AppParams params;
  params.exposure.automatic = 0;
  app_->configure(Still::calibration(), params, log_.sinks());
  bsp::play(others.source(), bsp::ReplayPace::kFast);
  ASSERT_EQ(app_->start(kOneCore, Drive::kTimed), Status::kOk);
  while (app_->poll() != Status::kStale) {
  }
  (void)app_->finish();
  EXPECT_TRUE(others.told.empty());
}

TEST_F(AppLife, PutsThePoseWhereItIsTold) {
  Still still(60);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  while (log_.frames < 40) ASSERT_EQ(app_->poll(), Status::kOk);
  const uint32_t resets = log_.resets;
  Command set = command(CommandKind::kSetPose);
  set.p_WB = Vec3(5, -6, 2);
  set.yaw_rad = 1.2;
  ASSERT_TRUE(app_->command(set).ok());
  set.p_WB.x() = std::nan("");
  ASSERT_TRUE(app_->command(set).ok());
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  ASSERT_EQ(log_.answers.size(), 2u);
  EXPECT_EQ(log_.answers[0].status, Status::kOk);
  EXPECT_EQ(log_.answers[1].status, Status::kBadData);
  const BodyState& end = log_.states.back();
  EXPECT_LT((end.T_WB.p - Vec3(5, -6, 2)).norm(), 0.01);
  EXPECT_NEAR(std::atan2(end.T_WB.R(1, 0), end.T_WB.R(0, 0)), 1.2, 0.005);
  EXPECT_GT(log_.resets, resets);
  EXPECT_EQ(counter(*app_, "losses"), 0u) << "the map has moved along";
}

// One recording after the other, each where it is told to go.
TEST_F(AppLife, RecordsAgainAndWritesOverNothing) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("pirvs_app_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string path = folder.string();
  bsp::set_storage_directory(path.c_str());
  log_.folders = {"0002/", "0001/"};
  Still still(150);
  play_fast(still);
  ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
  // Asked anew while the one before is still being written.
  const auto ask = [&](CommandKind kind) {
    Status status = Status::kStale;
    for (int i = 0; i < 40 && status == Status::kStale; ++i) {
      if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
      const size_t answers = log_.answers.size();
      EXPECT_TRUE(app_->command(command(kind)).ok());
      while (log_.answers.size() == answers && app_->poll() == Status::kOk) {
      }
      if (log_.answers.size() > answers) status = log_.answers.back().status;
    }
    return status;
  };
  const auto run_to = [&](int frames) {
    while (log_.frames < frames && app_->poll() == Status::kOk) {
    }
  };
  EXPECT_EQ(ask(CommandKind::kStartRecording), Status::kOk);
  run_to(15);
  EXPECT_EQ(ask(CommandKind::kStopRecording), Status::kOk);
  EXPECT_EQ(ask(CommandKind::kStartRecording), Status::kOk);
  const int begin = log_.frames;
  EXPECT_LT(begin, 100);
  run_to(begin + 10);
  EXPECT_EQ(ask(CommandKind::kStopRecording), Status::kOk);
  EXPECT_EQ(ask(CommandKind::kStartRecording), Status::kFull) << "no third folder";
  while (app_->poll() == Status::kOk) {
  }
  EXPECT_EQ(app_->finish(), Status::kOk);
  const auto images = [&](const char* of) {
    std::vector<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(folder / of / "mav0/cam0/data")) {
      names.push_back(file.path().filename());
    }
    std::sort(names.begin(), names.end());
    return names;
  };
  const auto first = images("0001"), second = images("0002");
  EXPECT_GE(first.size(), 13u);
  EXPECT_GE(second.size(), 9u);
  EXPECT_LT(first.back(), second.front());
  EXPECT_EQ(counter(*app_, "frames_recorded"), first.size() + second.size());
  EXPECT_EQ(counter(*app_, "record_map_dropped"), 0u) << "nothing is kept for a recording's end";
  EXPECT_FALSE(std::filesystem::exists(folder / "mav0"));
  bsp::set_storage_directory(".");
  std::filesystem::remove_all(folder);
}

TEST_F(AppLife, FindsItsPlaceInASavedMap) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("pirvs_app_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string path = folder.string();
  bsp::set_storage_directory(path.c_str());
  Command save = command(CommandKind::kSaveMap), load = command(CommandKind::kLoadMap);
  std::strcpy(save.text, "hall.map");
  std::strcpy(load.text, "hall.map");
  {
    Still still(60);
    play_fast(still);
    ASSERT_EQ(app_->start(kOneCore, Drive::kLockstep), Status::kOk);
    while (log_.frames < 40) ASSERT_EQ(app_->poll(), Status::kOk);
    Command set = command(CommandKind::kSetPose);
    set.p_WB = Vec3(5, -6, 2);
    ASSERT_TRUE(app_->command(set).ok());
    ASSERT_TRUE(app_->command(save).ok());
    while (app_->poll() == Status::kOk) {
    }
    EXPECT_EQ(app_->finish(), Status::kOk);
    EXPECT_EQ(log_.answers.back().status, Status::kOk);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "hall.map"));
  EXPECT_FALSE(std::filesystem::exists(folder / "hall.map.part"));
  log_.answers.clear();
  log_.states.clear();
  Still again(60);
  play_fast(again);
  Command missing = load;
  std::strcpy(missing.text, "cellar.map");
  ASSERT_TRUE(app_->command(missing).ok());
  ASSERT_TRUE(app_->command(load).ok());
  EXPECT_EQ(app_->run(kOneCore, Drive::kLockstep), Status::kOk);
  ASSERT_EQ(log_.answers.size(), 2u);
  EXPECT_EQ(log_.answers[0].status, Status::kNotFound);
  EXPECT_EQ(log_.answers[1].status, Status::kOk);
  ASSERT_FALSE(log_.states.empty());
  EXPECT_LT((log_.states.back().T_WB.p - Vec3(5, -6, 2)).norm(), 0.05) << "in the map's frame";
  EXPECT_EQ(counter(*app_, "joins"), 1u);
  bsp::set_storage_directory(".");
  std::filesystem::remove_all(folder);
}

// What the thread sanitizer is for: two or three cores at work, and another thread that asks for
// everything that it may ask for, and commands.
TEST_F(AppLife, IsAskedAndCommandedFromAnotherThreadWhileItRuns) {
  for (const bool live : {false, true}) {
    Still still(live ? 80 : 2000);  // it is told to stop long before
    Log log;
    app_->configure(Still::calibration(), AppParams{}, log.sinks());
    bsp::play(still.source(), live ? bsp::ReplayPace::kRealTime : bsp::ReplayPace::kFast);
    if (live) app_->set_clock(bsp::replay_now);
    if (!live) app_->pace(fast_may_go_on);
    std::atomic<bool> ended{false};
    std::thread other([this, &log, &ended] {
      const Result<int> consumer = app_->poses().attach();
      ASSERT_TRUE(consumer.ok());
      int poses = 0;
      const auto ask_until = [&](int frames) {
        while (log.frames < frames && !ended) {
          NamedValue values[256];
          (void)app_->counters(values, 256);
          (void)app_->latency().imu_to_pose.summary();
          (void)app_->poses().lost(consumer.value());
          while (app_->poses().next(consumer.value()) != nullptr) ++poses;
          std::this_thread::yield();
        }
      };
      ask_until(20);
      Command set = command(CommandKind::kSetParameter);
      std::strcpy(set.text, "frontend.tracks_target");
      set.value = 60;
      (void)app_->command(set);
      ask_until(35);
      set = command(CommandKind::kSetPose);
      set.p_WB = Vec3(1, 2, 3);
      (void)app_->command(set);
      ask_until(45);
      (void)app_->command(command(CommandKind::kReset));
      ask_until(65);
      app_->poses().detach(consumer.value());
      (void)app_->command(command(CommandKind::kStop));
      EXPECT_GT(poses, 0);
    });
    (void)app_->run(live ? kTwoCores : kThreeCores, Drive::kTimed);
    ended = true;
    other.join();
    // The door lets go of frames that come too late.
    if (live && log.frames < 65) GTEST_SKIP() << "this machine cannot keep real time now";
    constexpr CommandKind kKinds[] = {CommandKind::kSetParameter, CommandKind::kSetPose,
                                      CommandKind::kReset, CommandKind::kStop};
    ASSERT_EQ(log.answers.size(), std::size(kKinds));
    for (size_t i = 0; i < std::size(kKinds); ++i) {
      EXPECT_EQ(log.answers[i].kind, kKinds[i]);
      EXPECT_EQ(log.answers[i].status, Status::kOk) << i;
    }
    EXPECT_GE(log.frames, 65);
  }
}

// A sink runs within the door's step: one that dawdles makes the door late.
struct Dawdler {
  int late = 0, overruns = 0;
  TimeNs first = 0, last = 0;

  AppSinks sinks() {
    AppSinks sinks;
    sinks.context = this;
    sinks.frame = [](void*, const FrameReport&) {
      const TimeNs end = bsp::now() + 20'000'000;
      while (bsp::now() < end) {
      }
    };
    sinks.late = [](void* context, TimeNs, const LateTask& task) {
      Dawdler& self = *static_cast<Dawdler*>(context);
      if (std::strcmp(task.name, "door") != 0) return;
      self.last = bsp::now();
      if (self.late++ == 0) self.first = self.last;
      self.overruns += static_cast<int>(task.overruns);
    };
    return sinks;
  }
};

TEST_F(AppLife, TellsOfATaskThatIsLateAgainAndAgain) {
  Still still(60);
  Dawdler dawdler;
  app_->configure(Still::calibration(), AppParams{}, dawdler.sinks());
  bsp::play(still.source(), bsp::ReplayPace::kRealTime);
  EXPECT_EQ(app_->run(kTwoCores, Drive::kTimed), Status::kOk);
  EXPECT_GE(dawdler.late, 2);
  EXPECT_LE(dawdler.late, 1.1 + to_seconds(dawdler.last - dawdler.first)) << "once a second";
  EXPECT_GE(dawdler.overruns, 20);
  EXPECT_GE(counter(*app_, "overruns_door"), static_cast<uint64_t>(dawdler.overruns));
}

// The clock may not get into what a replay tells.
TEST_F(AppLife, TellsNothingOfTimeInAReplay) {
  for (const bool threads : {false, true}) {
    Still still(30);
    Dawdler dawdler;
    app_->configure(Still::calibration(), AppParams{}, dawdler.sinks());
    bsp::play(still.source(), bsp::ReplayPace::kFast);
    app_->pace(threads ? fast_may_go_on : lockstep_may_go_on);
    EXPECT_EQ(app_->run(threads ? kTwoCores : kOneCore, threads ? Drive::kTimed : Drive::kLockstep),
              Status::kOk);
    EXPECT_GE(counter(*app_, "overruns_door"), 25u);
    EXPECT_EQ(dawdler.late, 0);
  }
}

TEST_F(AppLife, LagsByFramesHoweverFastMappingIs) {
  std::vector<BodyState> states[2];
  for (const bool threads : {false, true}) {
    Still still(60);
    Log log;
    app_->configure(Still::calibration(), AppParams{}, log.sinks());
    app_->delay_mapping(3);
    bsp::play(still.source(), bsp::ReplayPace::kFast);
    app_->pace(lockstep_may_go_on);
    EXPECT_EQ(app_->run(threads ? kTwoCores : kOneCore, threads ? Drive::kTimed : Drive::kLockstep),
              Status::kOk);
    states[threads] = log.states;
  }
  ASSERT_EQ(states[0].size(), states[1].size());
  for (size_t i = 0; i < states[0].size(); ++i) {
    EXPECT_EQ(states[0][i].T_WB.p, states[1][i].T_WB.p) << i;
  }
}

TEST(MapGate, LetsThroughWhatWasSentSoManyFramesBefore) {
  MapGate gate;
  EXPECT_TRUE(gate.ready(0)) << "free";
  gate.configure(2);
  const uint32_t sent[] = {0, 1, 1, 4, 5};
  const uint32_t limit[] = {0, 0, 0, 1, 1};
  for (int frame = 0; frame < 5; ++frame) {
    gate.frame(sent[frame]);
    EXPECT_EQ(gate.limit(), limit[frame]) << frame;
  }
  EXPECT_FALSE(gate.ready(0));
  EXPECT_TRUE(gate.ready(1));
  gate.open();
  EXPECT_TRUE(gate.ready(0));
}

TEST(MapGate, FollowsARecordedRunAsFarAsItsKeyframesExist) {
  MapGate gate;
  gate.follow({nullptr, [](void*, uint32_t& keyframe) {
                 keyframe = 57;
                 return true;
               }});
  gate.frame(60);
  EXPECT_EQ(gate.limit(), 57u);
  gate.frame(3);
  EXPECT_EQ(gate.limit(), 3u) << "it began in the midst of a run: nothing would ever be ready";
}

}  // namespace
}  // namespace pirvs
