// A run's recording gives its items again, whatever came and when.
#include "tools/run/feed.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>
#include <memory>

#include "bsp/linux/storage.h"
#include "bsp/replay/sensors.h"
#include "modules/recorder/recorder.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;
constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kBegin = 1'500'000'000'000'000'000;
constexpr int kWidth = 64, kHeight = 48;

Calibration calibration() {
  Calibration out;
  for (Camera& camera : out.camera) {
    camera.width = kWidth;
    camera.height = kHeight;
    camera.fx = camera.fy = 40;
    camera.cx = kWidth / 2;
    camera.cy = kHeight / 2;
  }
  out.camera[1].T_BC.p.x() = 0.1;
  out.camera_time_offset_ns = 3 * kMs;
  return out;
}

// A device: pushes into its door as an intake does, with a recorder before it.
class Device {
 public:
  Device() {
    door_->configure(calibration(), DoorParams{});
    const Calibration c = calibration();
    EXPECT_EQ(recorder_->start(c.camera, 2, c.imu, c.camera_time_offset_ns), Status::kOk);
    bsp::play(camera(), bsp::ReplayPace::kFast);
  }
  void push(const Arrival& arrival, bool at_once = false) {
    at_once = at_once && !door_->is_lost(Sensor::kImu);
    if (arrival.kind != ArrivalKind::kImu) drain();
    const bool of_cameras =
        arrival.kind == ArrivalKind::kFrame ||
        (arrival.kind == ArrivalKind::kFault && arrival.sensor == Sensor::kCamera);
    if (of_cameras && !door_->wants_frame()) return;
    recorder_->arrival(arrival);
    while (recorder_->step() == Step::kAgain) {
    }
    door_->push(arrival);
    if (!at_once) drain();
  }
  void drain() {
    DoorItem item;
    while (door_->next(item) == Status::kOk) {
      items.push_back(item);
      if (item.is_frame()) door_->release();
    }
  }
  void frame(TimeNs t, uint8_t present = 3, TimeNs late = 0) {
    StereoFrame out;
    out.t = t;
    out.present = present;
    out.late[1] = late;
    for (uint8_t& pixel : pixels_) pixel = uint8_t(pixel * 5 + 13 + frames_);
    ++frames_;
    for (int c = 0; c < 2; ++c) {
      if ((present >> c & 1) != 0) out.image[c] = {pixels_.data() + c, kWidth, kHeight, kWidth + 1};
    }
    next_ = out;
    ASSERT_EQ(bsp::camera_poll(out), Status::kOk);
    push(arrival_of(out));
    bsp::camera_release(out.id);
  }
  void finish() {
    push(arrival_of(ArrivalKind::kEnd, Sensor::kImu));
    push(arrival_of(ArrivalKind::kEnd, Sensor::kCamera));
    recorder_->finish();
  }
  bool is_lost(Sensor sensor) const { return door_->is_lost(sensor); }
  const DoorLosses& losses() const { return door_->losses(); }

  std::vector<DoorItem> items;

 private:
  // Lends what frame() has made.
  bsp::RecordingSource camera() {
    return {this, [](void*, ImuSample&) { return false; },
            [](void* context, StereoFrame& out) {
              out = static_cast<Device*>(context)->next_;
              return true;
            },
            [](void*, FrameId) {}};
  }

  StereoFrame next_;
  int frames_ = 0;
  std::vector<uint8_t> pixels_ = std::vector<uint8_t>((kWidth + 1) * (kHeight + 1), 7);
  std::unique_ptr<Door> door_ = std::make_unique<Door>();
  std::unique_ptr<Recorder> recorder_ = std::make_unique<Recorder>();
};

// Four seconds in which everything goes wrong; samples come in bursts, as while a frame is tracked.
void live(Device& device) {
  for (TimeNs t = 1'000 * kMs; t < 5'000 * kMs; t += 5 * kMs) {
    const bool imu_silent = t > 3'000 * kMs && t < 4'500 * kMs;
    const bool cameras_silent = t > 1'800 * kMs && t < 2'400 * kMs;
    const double s = to_seconds(t);
    ImuSample sample = {kBegin + t, Vec3(0.1 * s, -s, 0.2), Vec3(s, 0.3, 9.81)};
    if (t % (700 * kMs) == 0) sample.f_B.x() = std::numeric_limits<double>::quiet_NaN();
    if (t % (900 * kMs) == 0) sample.w_B.y() += 30;
    if (t % (1'100 * kMs) == 0) sample.t -= 60 * kMs;
    // A lost sensor is asked once for each tick.
    if (!imu_silent && device.is_lost(Sensor::kImu)) device.push(tick_at(t));
    if (!imu_silent)
      device.push(arrival_of(sample, t % (800 * kMs) == 0), t % (50 * kMs) > 20 * kMs);
    if (t % (50 * kMs) != 25 * kMs) continue;
    const bool back = t == 2'725 * kMs;
    const uint8_t present = t % (400 * kMs) == 25 * kMs ? 1 : 3;
    if (!cameras_silent) {
      device.frame(kBegin + t - 17 * kMs - (back ? 200 * kMs : 0), present,
                   t == 2'825 * kMs ? 40 * kMs : 0);
    }
    device.push(tick_at(t));
    if (imu_silent) {
      for (int i = 0; i < (device.is_lost(Sensor::kImu) ? 1 : 3); ++i) {
        device.push(arrival_of(ArrivalKind::kFault, Sensor::kImu, Status::kBusFault));
      }
      device.push(arrival_of(ArrivalKind::kFault, Sensor::kCamera, Status::kTimeout));
    }
    if (t == 1'525 * kMs) {
      Command command;
      command.kind = CommandKind::kSetParameter;
      command.value = 0.25f;
      std::snprintf(command.text, sizeof command.text, "door.gap_s, \"x\"");
      device.push(arrival_of(command));
    }
  }
  device.finish();
}

TEST(feed, a_recorded_run_gives_the_same_items) {
  const fs::path folder = fs::temp_directory_path() / ("pirvs_feed_" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string path = folder.string();
  bsp::set_storage_directory(path.c_str());
  Device device;
  live(device);
  bsp::set_storage_directory(".");
  ASSERT_GT(device.losses()[DoorLoss::kImuSilent], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kCameraSilent], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kImuLostDevice], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kFrameBackwards], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kImuBackwards], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kImuNotFinite], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kImuLost], 0u);

  const Recording recording = open_recording(path, {});
  Feed feed(recording);
  bsp::play(feed.source(), bsp::ReplayPace::kFast);
  const auto door = std::make_unique<Door>();
  DoorListener listener;
  listener.release = Intake::release;
  door->configure(recording.calibration, DoorParams{}, listener);
  Intake intake;
  intake.configure(door.get(), {}, feed.commands());
  std::vector<DoorItem> items;
  for (DoorItem item;;) {
    const Status status = door->next(item);
    if (status == Status::kEmpty && intake.poll()) continue;
    if (status != Status::kOk) {
      EXPECT_EQ(status, Status::kStale);
      break;
    }
    items.push_back(item);
    if (item.is_frame()) door->release();
  }
  ASSERT_EQ(items.size(), device.items.size());
  for (size_t i = 0; i < items.size(); ++i) {
    const DoorItem &is = items[i], &was = device.items[i];
    ASSERT_EQ(is.kind, was.kind) << i;
    if (is.kind == DoorItemKind::kEvent) {
      EXPECT_EQ(is.event, was.event);
    }
    if (is.is_imu()) {
      EXPECT_EQ(is.imu.t, was.imu.t) << i;
      EXPECT_TRUE(is.imu.w_B == was.imu.w_B && is.imu.f_B == was.imu.f_B) << i;
      EXPECT_EQ(is.imu.gap_s, was.imu.gap_s);
      EXPECT_EQ(is.broken, was.broken);
    } else if (is.is_frame()) {
      EXPECT_EQ(is.frame.t, was.frame.t);
      EXPECT_EQ(is.frame.images.present, was.frame.images.present) << i;
    } else if (is.kind == DoorItemKind::kCommand) {
      EXPECT_STREQ(is.command.text, was.command.text);
      EXPECT_EQ(is.command.value, was.command.value);
    }
  }
  for (int i = 0; i < int(DoorLoss::kCount); ++i) {
    EXPECT_EQ(door->losses().count[i], device.losses().count[i]) << name(DoorLoss(i));
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace pirvs::tools
