#include "tools/dataset/pack_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <sstream>

#include "bsp/replay/pack.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

struct Packed {
  TestRecording folder;
  std::string path = folder.path("recording.pack");

  size_t pack() {
    return write_pack(open_recording(folder.folder(), {}), path, [](size_t, size_t) {});
  }
  std::string error_of(const std::string& bytes) const {
    write(path, bytes);
    try {
      open_recording(path, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
};

void expect_equal(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(a.d[i], b.d[i]);
  EXPECT_EQ(a.T_BC.R, b.T_BC.R);
  EXPECT_EQ(a.T_BC.p, b.T_BC.p);
}

TEST(pack, has_the_fixes_and_where_their_antenna_sits) {
  Packed packed;
  packed.folder.write("gnss0/sensor.yaml",
                      "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, "
                      "0.3, 0, 0, 0, 1]\ntime_offset: -0.01\nlatency: 0.02\n");
  const Recording empty = open_recording(packed.folder.folder(), {});
  const std::string begin = std::to_string(empty.imu.front().t);
  packed.folder.write("gnss0/data.csv",
                      "#timestamp [ns],a,b,c,d,e,f,g,h,i,fix\n" + begin +
                          ",47.1234567891,8.5,488.25,1,2,,0.01,0.02,0.03,fixed\n" +
                          std::to_string(empty.imu.back().t) + ",47.1,8.5,488,,,,1,2,,3d\n");
  packed.pack();
  const Recording folder = open_recording(packed.folder.folder(), {});
  const Recording pack = open_recording(packed.path, {});
  ASSERT_EQ(folder.gnss.size(), 2u);
  ASSERT_EQ(pack.gnss.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const GnssFix &a = folder.gnss[i], &b = pack.gnss[i];
    EXPECT_EQ(a.t, b.t);
    EXPECT_EQ(a.latitude_deg, b.latitude_deg);
    EXPECT_EQ(a.height_m, b.height_m);
    EXPECT_EQ(a.v_ned.head<2>(), b.v_ned.head<2>());
    EXPECT_EQ(std::isnan(a.v_ned.z()), std::isnan(b.v_ned.z()));
    EXPECT_EQ(a.sigma_vertical_m, b.sigma_vertical_m);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.has_velocity, b.has_velocity);
  }
  EXPECT_TRUE(pack.gnss_apart);
  EXPECT_EQ(pack.calibration.gnss.p_BA, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(pack.calibration.gnss.time_offset_ns, -10'000'000);
  EXPECT_EQ(pack.gnss_sensor.latency_ns, 20'000'000);
  std::string wrong = read(packed.path);
  bsp::PackHeader header;
  std::memcpy(&header, wrong.data(), sizeof header);
  const size_t fixes = sizeof header + header.imu_count * sizeof(bsp::PackedSample) +
                       header.frame_count * sizeof(bsp::PackedFrame);
  wrong[fixes + offsetof(bsp::PackedFix, type)] = 9;
  EXPECT_NE(packed.error_of(wrong).find("damaged"), std::string::npos);
}

TEST(pack, plays_what_the_folder_plays) {
  Packed packed;
  std::filesystem::remove(packed.folder.image(1, 3));  // a frame without its right image
  const size_t bytes = packed.pack();
  EXPECT_EQ(bytes, std::filesystem::file_size(packed.path));
  const Recording folder = open_recording(packed.folder.folder(), {});
  const Recording pack = open_recording(packed.path, {});
  for (int c = 0; c < 2; ++c)
    expect_equal(folder.calibration.camera[c], pack.calibration.camera[c]);
  EXPECT_EQ(folder.calibration.imu.gyro_noise, pack.calibration.imu.gyro_noise);
  EXPECT_EQ(folder.calibration.imu.accel_walk, pack.calibration.imu.accel_walk);
  EXPECT_EQ(folder.calibration.camera_time_offset_ns, pack.calibration.camera_time_offset_ns);
  ASSERT_EQ(folder.imu.size(), pack.imu.size());
  for (size_t i = 0; i < pack.imu.size(); ++i) {
    EXPECT_EQ(folder.imu[i].t, pack.imu[i].t);
    EXPECT_EQ(folder.imu[i].w_B, pack.imu[i].w_B);
    EXPECT_EQ(folder.imu[i].f_B, pack.imu[i].f_B);
  }
  Player folder_player(folder), pack_player(pack);
  int frames = 0;
  for (const StereoFrame* a = folder_player.next(); a != nullptr; a = folder_player.next()) {
    const StereoFrame* const b = pack_player.next();
    ASSERT_NE(b, nullptr);
    EXPECT_EQ(a->t, b->t);
    EXPECT_EQ(a->present, b->present);
    EXPECT_EQ(a->present, frames == 3 ? 1 : 3);
    for (int c = 0; c < 2; ++c) {
      for (int y = 0; y < a->image[c].height; ++y) {
        EXPECT_EQ(std::memcmp(a->image[c].row(y), b->image[c].row(y), size_t(a->image[c].width)),
                  0);
      }
    }
    folder_player.release(a);
    pack_player.release(b);
    ++frames;
  }
  EXPECT_EQ(frames, TestRecording::kFrames);
  EXPECT_EQ(pack_player.next(), nullptr);
}

TEST(pack, a_part_of_a_pack_can_be_played) {
  Packed packed;
  packed.pack();
  RecordingOptions options;
  options.start_s = 0.1;
  options.duration_s = 0.2;
  EXPECT_EQ(open_recording(packed.path, options).frames.size(), 5u);
}

TEST(pack, refuses_what_is_cut_off_or_damaged) {
  Packed packed;
  packed.pack();
  const std::string good = read(packed.path);
  for (const double part : {0.1, 0.5, 0.99}) {
    EXPECT_NE(packed.error_of(good.substr(0, size_t(part * double(good.size())))).find("cut off"),
              std::string::npos);
  }
  // A bit flipped anywhere, from the calibration to the last pixel.
  for (const size_t at : {size_t{64}, size_t{200}, size_t{500}, good.size() / 2, good.size() - 1}) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    EXPECT_NE(packed.error_of(damaged).find("damaged"), std::string::npos) << at;
  }
  EXPECT_NE(packed.error_of("").find("not a packed"), std::string::npos);
  EXPECT_NE(packed.error_of(std::string(5000, 'x')).find("not a packed"), std::string::npos);
  std::string version = good;
  version[offsetof(bsp::PackHeader, version)] = 99;
  EXPECT_NE(packed.error_of(version).find("another version"), std::string::npos);
  EXPECT_EQ(packed.error_of(good), "no error");
}

// Counts and offsets that lead out of the block, under a checksum that is right.
TEST(pack, refuses_offsets_beyond_its_end) {
  Packed packed;
  packed.pack();
  const std::string good = read(packed.path);
  const auto refused = [&](size_t at, uint64_t value, size_t size) {
    alignas(bsp::kPackAlign) static char block[200'000];
    ASSERT_LE(good.size(), sizeof block);
    std::memcpy(block, good.data(), good.size());
    std::memcpy(block + at, &value, size);
    const uint64_t sum = bsp::pack_checksum(block, good.size());
    std::memcpy(block + offsetof(bsp::PackHeader, checksum), &sum, sizeof sum);
    bsp::Pack pack;
    EXPECT_EQ(pack.open(block, good.size()), Status::kBadData) << at;
  };
  refused(offsetof(bsp::PackHeader, imu_count), 0xffffffff, 4);
  refused(offsetof(bsp::PackHeader, frame_count), 0xffffffff, 4);
  refused(offsetof(bsp::PackHeader, camera) + offsetof(bsp::PackedCamera, width), 0x7fffffff, 4);
  refused(offsetof(bsp::PackHeader, camera) + offsetof(bsp::PackedCamera, height), 0, 4);
  refused(offsetof(bsp::PackHeader, camera) + offsetof(bsp::PackedCamera, model), 7, 4);
  const size_t frames =
      sizeof(bsp::PackHeader) + TestRecording::kImuSamples * sizeof(bsp::PackedSample);
  refused(frames + offsetof(bsp::PackedFrame, image), UINT64_MAX - 63, 8);
  refused(frames + offsetof(bsp::PackedFrame, image), good.size() / 64 * 64, 8);
  refused(frames + offsetof(bsp::PackedFrame, image), 65, 8);
}

TEST(pack, leaves_nothing_half_written) {
  Packed packed;
  const Recording recording = open_recording(packed.folder.folder(), {});
  EXPECT_THROW(write_pack(recording, "/dev/full", [](size_t, size_t) {}), InputError);
  EXPECT_THROW(write_pack(recording, packed.folder.folder() + "/no/such", [](size_t, size_t) {}),
               InputError);
}

}  // namespace
}  // namespace pirvs::tools
