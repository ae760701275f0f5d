// The IIO driver on a tree of files that looks like /sys and /dev.
#include "bsp/linux/iio.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "bsp/api/clock.h"

namespace pirvs::bsp {
namespace {

namespace fs = std::filesystem;
constexpr TimeNs kMs = 1'000'000;

class Iio : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/pirvs_iio_XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    root_ = name;
    fs::create_directories(root_ + "/dev");
    put_device(3);
  }
  void TearDown() override {
    imu_.close();
    if (node_ >= 0) close(node_);
    fs::remove_all(root_);
  }

  // As inv_mpu6050 shows itself: big-endian, the time little-endian behind two bytes of padding.
  void put_device(int number) {
    folder_ = root_ + "/sys/bus/iio/devices/iio:device" + std::to_string(number);
    fs::create_directories(folder_ + "/scan_elements");
    fs::create_directories(folder_ + "/buffer");
    fs::create_directories(folder_ + "/trigger");
    put("name", "mpu6500\n");
    put("current_timestamp_clock", "realtime\n");
    put("sampling_frequency", "50\n");
    put("in_accel_scale", "0.000598\n");
    put("in_anglvel_scale", "0.001064724\n");
    put("buffer/enable", "0\n");
    put("buffer/length", "2\n");
    put("buffer/watermark", "8\n");
    put("trigger/current_trigger", "mpu6500-dev3\n");
    const char* kNames[] = {"in_accel_x",   "in_accel_y",   "in_accel_z",   "in_temp",
                            "in_anglvel_x", "in_anglvel_y", "in_anglvel_z", "in_timestamp"};
    for (int i = 0; i < 8; ++i) {
      const std::string base = std::string("scan_elements/") + kNames[i];
      put(base + "_en", i == 3 ? "1\n" : "0\n");
      put(base + "_index", std::to_string(i) + "\n");
      put(base + "_type", i == 7 ? "le:s64/64>>0\n" : "be:s16/16>>0\n");
    }
    const std::string node = root_ + "/dev/iio:device" + std::to_string(number);
    ASSERT_EQ(mkfifo(node.c_str(), 0600), 0);
    node_ = open(node.c_str(), O_RDWR | O_NONBLOCK);
    ASSERT_GE(node_, 0);
  }
  void put(const std::string& file, const std::string& text) {
    std::ofstream(folder_ + "/" + file) << text;
  }
  std::string get(const std::string& file) const {
    std::string text;
    std::getline(std::ifstream(folder_ + "/" + file), text);
    return text;
  }
  Status start(const char* device = "iio:3", TimeNs delay_ns = 0) {
    setup_.root = root_.c_str();
    setup_.device = device;
    setup_.delay_ns = delay_ns;
    imu_.configure(
        setup_, {this, [](void* self, const char* device_name, const char* what) {
                   static_cast<Iio*>(self)->told_.push_back(std::string(device_name) + ": " + what);
                 }});
    ImuSample sample;
    return imu_.poll(sample);
  }
  // accel 1 2 3, gyro -1 -2 -3 in counts.
  void sample(TimeNs t) {
    std::vector<uint8_t> bytes;
    for (const int16_t value : {1, 2, 3, -1, -2, -3}) {
      bytes.push_back(static_cast<uint8_t>(static_cast<uint16_t>(value) >> 8));
      bytes.push_back(static_cast<uint8_t>(value));
    }
    bytes.resize(16);
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<uint8_t>(t >> (8 * i)));
    ASSERT_EQ(write(node_, bytes.data(), bytes.size()), 24);
  }

  std::string root_, folder_;
  int node_ = -1;
  IioSetup setup_;
  IioImu imu_;
  std::vector<std::string> told_;
};

TEST(IioElements, AreReadAsTheDriverWritesThem) {
  struct Case {
    const char* type;
    std::vector<uint8_t> bytes;
    int64_t value;
  };
  const Case kCases[] = {
      {"be:s16/16>>0", {0xff, 0xfe}, -2},
      {"le:s16/16>>0", {0xfe, 0xff}, -2},
      {"le:u8/8>>0", {0xfe}, 254},
      {"le:s12/16>>4", {0xf7, 0xff}, -1},
      {"be:u12/16>>4", {0x12, 0x3f}, 0x123},
      {"le:s32/32>>0", {0, 0, 0, 0x80}, INT32_MIN},
      {"le:s64/64>>0", {1, 0, 0, 0, 0, 0, 0, 0}, 1},
      {"le:s24/32>>8", {9, 0xff, 0xff, 0xff}, -1},
  };
  for (const Case& c : kCases) {
    IioElement element;
    ASSERT_TRUE(read_element_type(c.type, element)) << c.type;
    EXPECT_EQ(read_element(element, c.bytes.data()), c.value) << c.type;
  }
  for (const char* bad : {"", "s16/16>>0", "be:f32/32>>0", "be:s16", "be:s16/12>>0", "be:s17/16>>0",
                          "be:s16/16>>1", "be:s16/16>>", "be:s0/16>>0"}) {
    IioElement element;
    EXPECT_FALSE(read_element_type(bad, element)) << bad;
  }
}

TEST_F(Iio, SetsWhatItNeedsAndPutsItBack) {
  ASSERT_EQ(start("iio:mpu6500"), Status::kEmpty);
  EXPECT_EQ(get("current_timestamp_clock"), "monotonic");
  EXPECT_EQ(get("sampling_frequency"), "200");
  EXPECT_EQ(get("buffer/length"), "256");
  EXPECT_EQ(get("buffer/watermark"), "1");
  EXPECT_EQ(get("buffer/enable"), "1");
  EXPECT_EQ(get("scan_elements/in_accel_z_en"), "1");
  EXPECT_EQ(get("scan_elements/in_temp_en"), "0");
  EXPECT_EQ(imu_.rate_hz(), 200);
  imu_.close();
  EXPECT_EQ(get("current_timestamp_clock"), "realtime");
  EXPECT_EQ(get("sampling_frequency"), "50");
  EXPECT_EQ(get("buffer/length"), "2");
  EXPECT_EQ(get("buffer/watermark"), "8");
  EXPECT_EQ(get("buffer/enable"), "0");
  EXPECT_EQ(get("scan_elements/in_accel_z_en"), "0");
  EXPECT_EQ(get("scan_elements/in_temp_en"), "1");
}

TEST_F(Iio, SamplesHaveScaleMountAndTime) {
  put("in_accel_mount_matrix", "0, 1, 0; -1, 0, 0; 0, 0, 1\n");
  ASSERT_EQ(start("iio:3", 3 * kMs), Status::kEmpty);
  const TimeNs t = now();
  sample(t);
  sample(t + 5 * kMs);
  ImuSample got;
  ASSERT_EQ(imu_.poll(got), Status::kOk);
  EXPECT_EQ(got.t, t - 3 * kMs) << "less the filter's delay";
  EXPECT_EQ(got.f_B, Vec3(2 * 0.000598, -0.000598, 3 * 0.000598));
  EXPECT_EQ(got.w_B, Vec3(-0.001064724, -2 * 0.001064724, -3 * 0.001064724));
  ASSERT_EQ(imu_.poll(got), Status::kOk);
  EXPECT_EQ(imu_.poll(got), Status::kEmpty);
  EXPECT_EQ(imu_.counters().samples, 2u);
}

TEST_F(Iio, GapsAndAWrongClockAreCounted) {
  ASSERT_EQ(start(), Status::kEmpty);
  const TimeNs t = now();
  sample(t);
  sample(t + 5 * kMs);
  sample(t + 25 * kMs);
  sample(t + 30 * kMs);
  sample(t + 1'700'000'000'000 * kMs);  // seconds since 1970
  ImuSample got;
  EXPECT_EQ(imu_.poll(got), Status::kOk);
  EXPECT_EQ(imu_.poll(got), Status::kOk);
  EXPECT_EQ(imu_.poll(got), Status::kFull);
  EXPECT_EQ(got.t, t + 25 * kMs) << "this one is good";
  EXPECT_EQ(imu_.counters().lost, 3u);
  EXPECT_EQ(imu_.poll(got), Status::kOk);
  EXPECT_EQ(imu_.poll(got), Status::kBadData);
  EXPECT_EQ(imu_.counters().wrong_clock, 1u);
}

TEST_F(Iio, ManySamplesComeInOrderThroughShortReads) {
  ASSERT_EQ(start(), Status::kEmpty);
  const TimeNs t = now();
  ImuSample got;
  for (int i = 0; i < 500; ++i) {
    if (i % 50 == 0) {
      for (int k = 0; k < 50; ++k) sample(t + i + k);
    }
    ASSERT_EQ(imu_.poll(got), Status::kOk);
    EXPECT_EQ(got.t, t + i);
  }
  EXPECT_EQ(imu_.poll(got), Status::kEmpty);
}

TEST_F(Iio, GoesAndComesBack) {
  ASSERT_EQ(start(), Status::kEmpty);
  close(node_);  // the FIFO's end: as a node whose device has gone
  node_ = -1;
  const std::string away = folder_ + ".away";
  fs::rename(folder_, away);
  ImuSample got;
  EXPECT_EQ(imu_.poll(got), Status::kBusFault);
  EXPECT_FALSE(imu_.is_open());
  const TimeNs begin = now();
  int faults = 0, empty = 0;
  while (now() < begin + IioImu::kRetry_ns + 10 * kMs) {
    const Status status = imu_.poll(got);
    EXPECT_TRUE(status == Status::kBusFault || status == Status::kEmpty);
    ++(status == Status::kBusFault ? faults : empty);
  }
  EXPECT_GT(faults, 3);
  EXPECT_LE(faults, 22) << "now and then";
  EXPECT_GT(empty, faults) << "who asks until there is nothing more comes to an end";
  fs::rename(away, folder_);
  put("buffer/enable", "0\n");
  node_ = open((root_ + "/dev/iio:device3").c_str(), O_RDWR | O_NONBLOCK);
  const TimeNs back = now();
  while (!imu_.is_open() && now() < back + 10 * IioImu::kRetry_ns) (void)imu_.poll(got);
  EXPECT_TRUE(imu_.is_open());
  const std::vector<std::string> kTold = {
      "iio:3: IMU started", "iio:3: IMU unplugged, waiting for it",
      "iio:3: no such IMU, waiting for it", "iio:3: IMU started"};
  EXPECT_EQ(told_, kTold);
}

TEST_F(Iio, TouchesNothingWithoutItsNode) {
  put("buffer/enable", "1\n");  // another program's
  fs::remove(root_ + "/dev/iio:device3");
  EXPECT_EQ(start(), Status::kBusFault);
  EXPECT_EQ(told_, std::vector<std::string>{"iio:3: the IMU's node cannot be opened"});
  EXPECT_EQ(get("buffer/enable"), "1");
  EXPECT_EQ(get("current_timestamp_clock"), "realtime");
}

TEST_F(Iio, SaysWhyThereIsNone) {
  struct Broken {
    const char* what;
    const char* file;
    const char* text;  // nullptr: the file is not there
  };
  const Broken kBroken[] = {
      {"no such IMU, waiting for it", "name", nullptr},
      {"the IMU has no buffer, or no permission to use it", "buffer/enable", nullptr},
      {"the IMU's stamps cannot be set to the monotonic clock", "current_timestamp_clock", nullptr},
      {"not an IMU: force, rate or time is missing", "scan_elements/in_anglvel_y_type", nullptr},
      {"not an IMU: force, rate or time is missing", "scan_elements/in_accel_x_type", "float\n"},
      {"not an IMU: force, rate or time is missing", "scan_elements/in_accel_x_index", "1\n"},
      {"the IMU does not tell its scale", "in_accel_scale", "x\n"},
      {"the IMU has no trigger: write one to trigger/current_trigger", "trigger/current_trigger",
       "\n"},
      {"the IMU refuses its buffer's length", "buffer/length", nullptr},
  };
  for (const Broken& broken : kBroken) {
    const std::string path = folder_ + "/" + broken.file;
    std::string kept;
    std::getline(std::ifstream(path), kept, '\0');
    if (broken.text == nullptr) fs::remove(path);
    if (broken.text != nullptr) put(broken.file, broken.text);
    told_.clear();
    imu_.~IioImu();
    new (&imu_) IioImu;
    EXPECT_EQ(start(), Status::kBusFault) << broken.file;
    EXPECT_EQ(told_, std::vector<std::string>{std::string("iio:3: ") + broken.what});
    EXPECT_EQ(get("sampling_frequency"), "50") << "put back: " << broken.file;
    put(broken.file, kept);
  }
}

}  // namespace
}  // namespace pirvs::bsp
