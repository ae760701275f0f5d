#include "modules/recorder/recorder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "bsp/linux/storage.h"
#include "bsp/replay/sensors.h"

namespace pirvs {
namespace {

namespace fs = std::filesystem;

class recorder : public testing::Test {
 protected:
  recorder() {
    folder_ = fs::temp_directory_path() / ("pirvs_recorder_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    path_ = folder_.string();
    bsp::set_storage_directory(path_.c_str());
    for (Camera& camera : calibration_.camera) {
      camera.width = 4;
      camera.height = 2;
      camera.fx = camera.fy = 1.0 / 3;
    }
    bsp::play(camera(), bsp::ReplayPace::kFast);
  }
  ~recorder() override {
    bsp::set_storage_directory(".");
    fs::remove_all(folder_);
  }
  // A frame that the camera has lent; the recorder may hold it on.
  void record(TimeNs t, uint8_t present = 3, TimeNs late_1 = 0) {
    next_ = StereoFrame{};
    next_.t = t;
    next_.present = present;
    next_.late[1] = late_1;
    for (ImageView& image : next_.image) image = {pixels_.data(), 4, 2, 5};  // wider than it shows
    StereoFrame frame;
    ASSERT_EQ(bsp::camera_poll(frame), Status::kOk);
    recorder_->arrival(arrival_of(frame));
    bsp::camera_release(frame.id);
  }
  bsp::RecordingSource camera() {
    return {this, [](void*, ImuSample&) { return false; },
            [](void* context, StereoFrame& out) {
              out = static_cast<recorder*>(context)->next_;
              return true;
            },
            [](void* context, FrameId) { ++static_cast<recorder*>(context)->released_; }};
  }
  std::string content_of(const std::string& file) const {
    std::ostringstream text;
    text << std::ifstream(path_ + "/" + file, std::ios::binary).rdbuf();
    return text.str();
  }
  std::string content(const std::string& file) const { return content_of("mav0/" + file); }
  void write_all() {
    recorder_->set_core(1);
    recorder_->end();
    recorder_->run();
  }

  fs::path folder_;
  std::string path_;
  StereoFrame next_;
  int released_ = 0;
  Calibration calibration_;
  std::vector<uint8_t> pixels_ = {'a', 'b', 'c', 'd', '-', 'e', 'f', 'g', 'h', '-'};
  std::unique_ptr<Recorder> recorder_ = std::make_unique<Recorder>();
};

TEST_F(recorder, writes_what_it_is_given) {
  calibration_.camera_time_offset_ns = 4'000'000;
  calibration_.gnss.p_BA = Vec3(0.1, 0, 0.8);
  ASSERT_EQ(recorder_->start(calibration_), Status::kOk);
  recorder_->arrival(arrival_of(ImuSample{5, Vec3(0.1, -1, 0), Vec3(0, 0, 9.81)}));
  record(7);
  record(9, 1);
  record(11, 3, 4);
  EXPECT_EQ(released_, 0) << "held until they are written";
  write_all();
  EXPECT_EQ(content("cam0/data/7.pgm"), "P5\n4 2\n255\nabcdefgh");
  EXPECT_EQ(content("cam0/data.csv"), "#timestamp [ns],filename\n7,7.pgm\n9,9.pgm\n11,11.pgm\n");
  EXPECT_EQ(content("cam1/data.csv"), "#timestamp [ns],filename\n7,7.pgm\n7,7_1.pgm\n");
  EXPECT_NE(content("imu0/data.csv").find("\n5,0.1,-1,0,0,0,9.81\n"), std::string::npos);
  EXPECT_NE(content("imu0/sensor.yaml").find("\nrate_hz: 200\n"), std::string::npos);
  EXPECT_NE(
      content("gnss0/sensor.yaml").find("1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0.8, 0, 0, 0, 1]"),
      std::string::npos);
  EXPECT_NE(content("cam1/sensor.yaml").find("\nresolution: [4, 2]\n"), std::string::npos);
  EXPECT_NE(content("cam1/sensor.yaml").find("\ntimeshift_cam_imu: 0.004\n"), std::string::npos);
  EXPECT_EQ(recorder_->frames_written(), 3u);
  EXPECT_EQ(released_, 3);
}

TEST_F(recorder, writes_the_order_of_all_that_comes) {
  ASSERT_EQ(recorder_->start(calibration_), Status::kOk);
  recorder_->arrival(arrival_of(ImuSample{5, Vec3::Zero(), Vec3::Zero()}, true));
  record(11, 3, 4);
  GnssFix fix;
  fix.t = 12;
  fix.latitude_deg = 0.1;
  fix.type = GnssFixType::kFloat;
  fix.v_ned = Vec3(1, 2, 3);
  recorder_->arrival(arrival_of(fix));
  recorder_->arrival(arrival_of(WheelSample{13, {-1.5, 7}, WheelKind::kTicks}));
  recorder_->arrival(arrival_of(bsp::GpioEdge{14, {4, 27}, true}));
  recorder_->arrival(tick_at(15));
  recorder_->arrival(arrival_of(ArrivalKind::kFault, Sensor::kCamera, Status::kTimeout));
  recorder_->arrival(arrival_of(ArrivalKind::kLost, Sensor::kImu));
  recorder_->arrival(arrival_of(ArrivalKind::kBack, Sensor::kImu));
  recorder_->arrival(arrival_of(ArrivalKind::kEnd, Sensor::kCamera));
  recorder_->decision(11, 3);
  write_all();
  EXPECT_EQ(content("order.csv"),
            "#kind,stamp [ns],more by kind\nimu,5,1\nframe,11,3,0,4,0\n"
            "gnss,12,3,0.1,0,0,0,0,0,1,2,3,0\nwheel,13,2,-1.5,7\nedge,14,4,27,1,0\ntick,15\n"
            "fault,camera,timeout\nlost,imu\nback,imu\nend,camera\n");
  EXPECT_EQ(content("maps.csv"), "#frame [ns],keyframe\n11,3\n");
}

TEST_F(recorder, drops_and_counts_what_the_writer_is_too_slow_for) {
  ASSERT_EQ(recorder_->start(calibration_), Status::kOk);
  EXPECT_TRUE(recorder_->has_room());
  for (TimeNs t = 1; t <= 10; ++t) record(t);
  EXPECT_FALSE(recorder_->has_room());
  EXPECT_EQ(released_, 4) << "frames that are dropped go back at once";
  for (TimeNs t = 1; t <= 1500; ++t) {
    recorder_->arrival(arrival_of(ImuSample{t, Vec3::Zero(), Vec3::Zero()}));
  }
  write_all();
  EXPECT_EQ(recorder_->losses()[RecordLoss::kFrameDropped], 10u - recorder_->frames_written());
  EXPECT_EQ(recorder_->frames_written(), 6u);
  EXPECT_EQ(recorder_->losses()[RecordLoss::kImuDropped], 1500u - 1024u);
  EXPECT_TRUE(recorder_->has_room());
  EXPECT_EQ(recorder_->losses()[RecordLoss::kNotWritten], 0u);
}

TEST_F(recorder, one_follows_the_other_in_a_folder_of_its_own) {
  ASSERT_EQ(recorder_->start(calibration_, "0001/"), Status::kOk);
  record(7);
  EXPECT_EQ(recorder_->start(calibration_, "0002/"), Status::kStale) << "it records";
  recorder_->stop();
  EXPECT_FALSE(recorder_->recording());
  EXPECT_EQ(recorder_->start(calibration_, "0002/"), Status::kStale)
      << "the last is not written yet";
  while (recorder_->step() == Step::kAgain) {
  }
  recorder_->finish();
  EXPECT_FALSE(recorder_->busy());
  recorder_->decision(7, 1);  // of a core that has not seen the end
  ASSERT_EQ(recorder_->start(calibration_, "0002/"), Status::kOk);
  record(5);  // the stamps of a new recording are judged by themselves
  write_all();
  EXPECT_EQ(content_of("0001/mav0/cam0/data.csv"), "#timestamp [ns],filename\n7,7.pgm\n");
  EXPECT_EQ(content_of("0002/mav0/cam0/data.csv"), "#timestamp [ns],filename\n5,5.pgm\n");
  EXPECT_EQ(content_of("0002/mav0/cam0/data/5.pgm"), "P5\n4 2\n255\nabcdefgh");
  EXPECT_EQ(content_of("0002/mav0/maps.csv"), "#frame [ns],keyframe\n");
  EXPECT_FALSE(fs::exists(folder_ / "mav0/cam0/data.csv"));
  EXPECT_EQ(recorder_->frames_written(), 2u);
}

TEST_F(recorder, says_at_the_start_that_it_cannot_write) {
  std::ofstream(path_ + "/mav0") << "a file where the folder should be";
  EXPECT_EQ(recorder_->start(calibration_), Status::kNotFound);
  EXPECT_FALSE(recorder_->started());
  recorder_->finish();
}

TEST_F(recorder, what_cannot_be_written_later_is_counted) {
  ASSERT_EQ(recorder_->start(calibration_), Status::kOk);
  fs::create_directories(path_ + "/mav0/cam0");
  std::ofstream(path_ + "/mav0/cam0/data") << "in the way";
  record(1);
  record(2);
  testing::internal::CaptureStderr();
  write_all();
  EXPECT_NE(testing::internal::GetCapturedStderr().find("the run goes on"), std::string::npos);
  EXPECT_EQ(recorder_->losses()[RecordLoss::kNotWritten], 4u);
  EXPECT_EQ(content("cam0/data.csv").find(".pgm"), std::string::npos)
      << "no image is listed that is not there";
}

}  // namespace
}  // namespace pirvs
