// A run's recording gives its items again, whatever came and when.
#include "tools/run/feed.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>

#include "bsp/linux/storage.h"
#include "bsp/replay/sensors.h"
#include "modules/recorder/recorder.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/order_file.h"
#include "tools/dataset/test_recording.h"

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
    EXPECT_EQ(recorder_->start(calibration()), Status::kOk);
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
  void frame(TimeNs t, uint8_t present = 3, TimeNs late = 0, uint32_t lost_before = 0) {
    StereoFrame out;
    out.t = t;
    out.lost_before = lost_before;
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

GnssFix fix_at(TimeNs t) {
  GnssFix fix;
  fix.t = kBegin + t;
  fix.latitude_deg = 47.0 + 1e-9 * double(t);
  fix.longitude_deg = -8.1 / 3;
  fix.height_m = 400.25;
  fix.v_ned = Vec3(0.1, -0.2, 1.0 / 7);
  fix.sigma_horizontal_m = 0.02;
  fix.sigma_vertical_m = std::numeric_limits<double>::infinity();
  fix.sigma_velocity_m_s = 0.1;
  fix.type = GnssFixType::kFixed;
  fix.has_velocity = t % (200 * kMs) == 0;
  return fix;
}

// What comes beside the cameras and the IMU, and a camera that is unplugged.
void others(Device& device, TimeNs t) {
  if (t % (100 * kMs) == 0) device.push(arrival_of(fix_at(t)));
  if (t % (40 * kMs) == 0) {
    device.push(arrival_of(
        WheelSample{kBegin + t - 7 * kMs, {0.1 * double(t), -1.0 / 3}, WheelKind::kTwist}));
  }
  if (t % (70 * kMs) == 0) {
    device.push(
        arrival_of(bsp::GpioEdge{kBegin + t, {4, 27}, t % (140 * kMs) == 0}, t % (350 * kMs) == 0));
  }
  if (t == 1'950 * kMs) device.push(arrival_of(ArrivalKind::kLost, Sensor::kCamera));
  if (t == 2'350 * kMs) device.push(arrival_of(ArrivalKind::kBack, Sensor::kCamera));
}

// Four seconds in which everything goes wrong; samples come in bursts, as while a frame is tracked.
void live(Device& device) {
  for (TimeNs t = 0; t < 1'000 * kMs; t += 5 * kMs) others(device, t);  // the IMU begins later
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
    others(device, t);
    if (t % (50 * kMs) != 25 * kMs) continue;
    const bool back = t == 2'725 * kMs;
    const uint8_t present = t % (400 * kMs) == 25 * kMs ? 1 : 3;
    if (!cameras_silent) {
      device.frame(kBegin + t - 17 * kMs - (back ? 200 * kMs : 0), present,
                   t == 2'825 * kMs ? 40 * kMs : 0, t == 2'425 * kMs ? 11 : 0);
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

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void expect_equal(const DoorItem& is, const DoorItem& was) {
  ASSERT_EQ(is.kind, was.kind);
  switch (is.kind) {
    case DoorItemKind::kEvent:
      EXPECT_EQ(is.event, was.event);
      break;
    case DoorItemKind::kImu:
      EXPECT_EQ(is.imu.t, was.imu.t);
      EXPECT_TRUE(is.imu.w_B == was.imu.w_B && is.imu.f_B == was.imu.f_B);
      EXPECT_EQ(is.imu.gap_s, was.imu.gap_s);
      EXPECT_EQ(is.broken, was.broken);
      break;
    case DoorItemKind::kFrame:
      EXPECT_EQ(is.frame.t, was.frame.t);
      EXPECT_EQ(is.frame.images.present, was.frame.images.present);
      EXPECT_EQ(is.frame.images.lost_before, was.frame.images.lost_before);
      break;
    case DoorItemKind::kGnss:
      EXPECT_EQ(is.gnss.t, was.gnss.t);
      EXPECT_EQ(is.gnss.latitude_deg, was.gnss.latitude_deg);
      EXPECT_EQ(is.gnss.longitude_deg, was.gnss.longitude_deg);
      EXPECT_EQ(is.gnss.height_m, was.gnss.height_m);
      EXPECT_EQ(is.gnss.v_ned, was.gnss.v_ned);
      EXPECT_EQ(is.gnss.sigma_horizontal_m, was.gnss.sigma_horizontal_m);
      EXPECT_EQ(is.gnss.sigma_vertical_m, was.gnss.sigma_vertical_m);
      EXPECT_EQ(is.gnss.sigma_velocity_m_s, was.gnss.sigma_velocity_m_s);
      EXPECT_EQ(is.gnss.type, was.gnss.type);
      EXPECT_EQ(is.gnss.has_velocity, was.gnss.has_velocity);
      break;
    case DoorItemKind::kWheel:
      EXPECT_EQ(is.wheel.t, was.wheel.t);
      EXPECT_EQ(is.wheel.kind, was.wheel.kind);
      for (int i = 0; i < 2; ++i) EXPECT_EQ(is.wheel.value[i], was.wheel.value[i]);
      break;
    case DoorItemKind::kEdge:
      EXPECT_EQ(is.edge.t, was.edge.t);
      EXPECT_TRUE(is.edge.pin == was.edge.pin);
      EXPECT_EQ(is.edge.level, was.edge.level);
      break;
    case DoorItemKind::kCommand:
      EXPECT_STREQ(is.command.text, was.command.text);
      EXPECT_EQ(is.command.value, was.command.value);
      break;
  }
}

TEST(feed, a_recorded_run_gives_the_same_items_and_the_same_recording) {
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
  ASSERT_GT(device.losses()[DoorLoss::kAsideBeforeImu], 16u);
  ASSERT_GT(device.losses()[DoorLoss::kAsideFull], 0u);
  ASSERT_GT(device.losses()[DoorLoss::kEdgesLost], 0u);
  ASSERT_EQ(device.losses()[DoorLoss::kFramesLost], 11u);
  ASSERT_EQ(device.losses()[DoorLoss::kCameraLostDevice], 1u);
  ASSERT_EQ(device.losses()[DoorLoss::kCameraBack], 1u);

  const Recording recording = open_recording(path, {});
  Feed feed(recording);
  bsp::play(feed.source(), bsp::ReplayPace::kFast);
  const auto door = std::make_unique<Door>();
  DoorListener listener;
  listener.release = Intake::release;
  door->configure(recording.calibration, DoorParams{}, listener);
  const fs::path second = folder / "again";
  const std::string second_path = second.string();
  fs::create_directories(second);
  bsp::set_storage_directory(second_path.c_str());
  const auto recorder = std::make_unique<Recorder>();
  const Calibration& c = recording.calibration;
  ASSERT_EQ(recorder->start(c), Status::kOk);
  const auto tap = [](void* to, const Arrival& arrival) {
    static_cast<Recorder*>(to)->arrival(arrival);
    while (static_cast<Recorder*>(to)->step() == Step::kAgain) {
    }
  };
  Intake intake;
  intake.configure(door.get(), {recorder.get(), tap}, feed.inbox());
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
  recorder->finish();
  bsp::set_storage_directory(".");
  ASSERT_EQ(items.size(), device.items.size());
  for (size_t i = 0; i < items.size(); ++i) {
    SCOPED_TRACE(i);
    ASSERT_NO_FATAL_FAILURE(expect_equal(items[i], device.items[i]));
  }
  for (int i = 0; i < int(DoorLoss::kCount); ++i) {
    EXPECT_EQ(door->losses().count[i], device.losses().count[i]) << name(DoorLoss(i));
  }
  for (const char* file : {"order.csv", "imu0/data.csv", "cam0/data.csv", "cam1/data.csv"}) {
    EXPECT_TRUE(content(folder / "mav0" / file) == content(second / "mav0" / file)) << file;
  }
  fs::remove_all(folder);
}

// A fix comes when the IMU has come to its time, and as much later as the receiver takes.
TEST(feed, fixes_come_late_by_the_latency) {
  const TestRecording files;
  files.write("gnss0/sensor.yaml", "latency: 0.02\n");
  files.write("gnss0/data.csv", "#timestamp [ns],a,b,c,d,e,f,g,h,i,fix\n" +
                                    std::to_string(TestRecording::kBegin_ns + 3'000'000) +
                                    ",47,8,400,,,,1,1,,3d\n");
  const Recording recording = open_recording(files.folder(), {});
  Feed feed(recording);
  const bsp::RecordingSource source = feed.source();
  const ArrivalSource told = feed.inbox();
  Arrival arrival;
  ImuSample sample;
  TimeNs came = 0;
  while (came == 0 && source.next_imu(source.context, sample)) {
    if (told.next(told.context, arrival)) came = sample.t;
  }
  EXPECT_EQ(arrival.kind, ArrivalKind::kGnss);
  EXPECT_EQ(came, TestRecording::kBegin_ns + 25'000'000);
  EXPECT_FALSE(told.next(told.context, arrival));
}

TEST(feed, a_row_of_the_order_that_makes_no_sense_is_named) {
  const fs::path file = fs::temp_directory_path() / ("pirvs_order_" + std::to_string(getpid()));
  const char* const bad[] = {"gps,1,0",
                             "imu,1",
                             "imu,1,2",
                             "frame,1,4,0,0,0",
                             "frame,1,3,0,0",
                             "frame,1,3,0,0,-1",
                             "edge,1,4,256,1,0",
                             "wheel,1,4,0,0",
                             "gnss,1,5,0,0,0,0,0,1,0,0,0,0",
                             "gnss,1,4,0,0,0,0,0,1,0,0,0",
                             "lost,gnss",
                             "command,8,0,0,0,0,0,x"};
  for (const char* row : bad) {
    std::ofstream(file) << "#heading\ntick,1\n" << row << "\n";
    try {
      (void)read_order(file.string());
      ADD_FAILURE() << row;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("line 3"), std::string::npos) << error.what();
    }
  }
  std::ofstream(file) << "tick,1\nlost,imu\nback,imu\nedge,5,4,255,1,0\nframe,1,3,0,0,0\nimu,7";
  EXPECT_EQ(read_order(file.string()).size(), 5u) << "the last one was cut off";
  fs::remove(file);
}

}  // namespace
}  // namespace pirvs::tools
