#include "tools/dataset/recording.h"

#include <gtest/gtest.h>

#include "modules/calibration/calibration_text.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

size_t value(const std::vector<Count>& counts, const std::string& name) {
  for (const Count& count : counts) {
    if (count.name == name) return count.value;
  }
  return 0;
}

std::string notes_of(const InputLog& log) {
  std::string out;
  for (const std::string& note : log.notes) out += note + "\n";
  return out;
}

// The message if opening fails, else an empty text.
std::string error_of(const std::string& folder, const RecordingOptions& options = {}) {
  try {
    const Recording recording = open_recording(folder, options);
    const Player player(recording);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

#define PIRVS_EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(recording, reads_an_asl_folder) {
  const TestRecording disk;
  for (const std::string& folder : {disk.folder(), disk.folder() + "/mav0"}) {
    const Recording recording = open_recording(folder, {});
    ASSERT_EQ(recording.frames.size(), size_t(TestRecording::kFrames));
    ASSERT_EQ(recording.imu.size(), size_t(TestRecording::kImuSamples));
    EXPECT_EQ(recording.truth.poses.size(), size_t(TestRecording::kImuSamples));
    EXPECT_FALSE(recording.truth.full_state);
    EXPECT_EQ(recording.frames[3].t, TestRecording::kBegin_ns + 150'000'000);
    EXPECT_EQ(recording.imu[1].w_B, Vec3(0.01, 0.02, 0.03));
    EXPECT_EQ(recording.imu[1].f_B, Vec3(0.1, 0.2, 9.81));
    const Camera& right = recording.calibration.camera[1];
    EXPECT_EQ(recording.calibration.cameras, 2);
    EXPECT_EQ(right.model, CameraModel::kPinholeRadtan);
    EXPECT_EQ(right.width, 64);
    EXPECT_EQ(right.fy, 51.0);
    EXPECT_EQ(right.d[3], 0.002);
    EXPECT_EQ(right.T_BC.p, Vec3(0.1, 0, 0));
    EXPECT_EQ(recording.calibration.imu.accel_walk, 4.0e-3);
    EXPECT_TRUE(recording.rejected.empty());
  }
}

TEST(recording, cuts_out_a_part) {
  const TestRecording disk;
  RecordingOptions options;
  options.start_s = 0.2;
  options.duration_s = 0.15;
  const Recording recording = open_recording(disk.folder(), options);
  ASSERT_EQ(recording.frames.size(), 4u);
  EXPECT_EQ(recording.frames[0].t, TestRecording::kBegin_ns + 200'000'000);
  EXPECT_LE(recording.imu.front().t, recording.frames.front().t);
  EXPECT_GE(recording.imu.back().t, recording.frames.back().t);
  options.start_s = 100;
  PIRVS_EXPECT_SAYS(error_of(disk.folder(), options), "no frames");
}

// All stamps of the test recording, 1.5e18 ns later than the device was started.
TEST(recording, stamped_since_the_device_was_started) {
  const TestRecording disk;
  for (const char* file : {"cam0/data.csv", "cam1/data.csv", "imu0/data.csv",
                           "state_groundtruth_estimate0/data.csv"}) {
    std::istringstream rows(disk.read(file));
    std::string text;
    for (std::string row; std::getline(rows, row);) {
      const size_t comma = row.find(',');
      if (row[0] != '#') {
        row = std::to_string(std::stoll(row.substr(0, comma)) - TestRecording::kBegin_ns +
                             61'000'000'000) +
              row.substr(comma);
      }
      text += row + "\n";
    }
    disk.write(file, text);
  }
  const Recording recording = open_recording(disk.folder(), {});
  EXPECT_EQ(recording.frames[3].t, 61'150'000'000);
  EXPECT_EQ(recording.imu[0].t, 60'980'000'000);
  EXPECT_EQ(recording.truth.poses[1].t - recording.truth.poses[0].t, 5'000'000);
  EXPECT_EQ(Player(recording).next()->present, 3);
}

TEST(recording, says_which_file_is_missing) {
  for (const char* file :
       {"cam0/sensor.yaml", "cam1/sensor.yaml", "imu0/sensor.yaml", "imu0/data.csv"}) {
    const TestRecording disk;
    std::filesystem::remove(disk.path(file));
    PIRVS_EXPECT_SAYS(error_of(disk.folder()), file);
  }
  const TestRecording disk;
  std::filesystem::remove(disk.path("cam0/data.csv"));
  std::filesystem::remove_all(disk.path("cam0/data"));
  PIRVS_EXPECT_SAYS(error_of(disk.folder()), "cam0/data.csv");
  PIRVS_EXPECT_SAYS(error_of("/nowhere"), "no such recording");
  PIRVS_EXPECT_SAYS(error_of("/"), "no cam0");
}

TEST(recording, one_camera_and_no_truth_are_read) {
  const TestRecording disk;
  std::filesystem::remove_all(disk.path("cam1"));
  std::filesystem::remove_all(disk.path("state_groundtruth_estimate0"));
  const Recording recording = open_recording(disk.folder(), {});
  EXPECT_EQ(recording.calibration.cameras, 1);
  EXPECT_TRUE(recording.truth.poses.empty());
  EXPECT_EQ(Player(recording).next()->present, 1);
}

TEST(recording, a_last_line_cut_off_is_counted) {
  const TestRecording disk;
  for (const char* file :
       {"cam0/data.csv", "imu0/data.csv", "state_groundtruth_estimate0/data.csv"}) {
    std::string text = disk.read(file);
    const size_t comma = text.rfind(',');
    disk.write(file, text.substr(0, file[0] == 'c' ? comma : comma - 4));
  }
  const Recording recording = open_recording(disk.folder(), {});
  EXPECT_EQ(value(recording.rejected, "image_rows_truncated"), 1u);
  EXPECT_EQ(value(recording.rejected, "frames_without_left"), 1u);
  EXPECT_EQ(value(recording.rejected, "imu_rows_truncated"), 1u);
  EXPECT_EQ(value(recording.rejected, "truth_rows_truncated"), 1u);
  EXPECT_EQ(recording.frames.back().image[0], "");
}

TEST(recording, a_bad_line_in_the_middle_is_named) {
  const TestRecording disk;
  disk.replace("imu0/data.csv", "980000000,0.01,", "980000000,zero,");
  PIRVS_EXPECT_SAYS(error_of(disk.folder()), "imu0/data.csv line 2");
  const TestRecording truth;
  truth.replace("state_groundtruth_estimate0/data.csv", ",0,0,1,0,0,0\n", ",0,nan,1,0,0,0\n");
  PIRVS_EXPECT_SAYS(error_of(truth.folder()), "not finite");
}

TEST(recording, rows_out_of_order_and_nan_are_counted) {
  const TestRecording disk;
  disk.replace("imu0/data.csv", ",0.01,0.02,", ",nan,0.02,");
  disk.replace("imu0/data.csv", "1500000000000000000,", "1500000000012500000,");
  disk.replace("imu0/data.csv", "1500000000010000000,", "1500000000005000000,");
  disk.replace("cam1/data.csv", "1500000000100000000,", "1500000000000000000,");
  const Recording recording = open_recording(disk.folder(), {});
  EXPECT_EQ(value(recording.rejected, "imu_samples_not_finite"), 1u);
  EXPECT_EQ(value(recording.rejected, "imu_rows_out_of_order"), 2u);
  EXPECT_EQ(value(recording.rejected, "imu_rows_repeated"), 1u);
  EXPECT_EQ(value(recording.rejected, "image_rows_out_of_order"), 1u);
  EXPECT_EQ(value(recording.rejected, "image_rows_repeated"), 1u);
  EXPECT_EQ(value(recording.rejected, "frames_without_right"), 1u);
  EXPECT_EQ(recording.imu.size(), size_t(TestRecording::kImuSamples) - 2);
  for (size_t i = 1; i < recording.imu.size(); ++i) {
    EXPECT_GT(recording.imu[i].t, recording.imu[i - 1].t);
  }
  PIRVS_EXPECT_SAYS(notes_of(recording), "2 of 119 IMU rows were out of order");
}

// Blocks of rows exchanged, as two threads write them, and each of them twice: the same recording.
TEST(recording, blocks_out_of_order_are_sorted) {
  const TestRecording disk;
  const Recording whole = open_recording(disk.folder(), {});
  std::istringstream in(disk.read("imu0/data.csv"));
  std::vector<std::string> rows;
  for (std::string row; std::getline(in, row);) rows.push_back(row + "\n");
  std::string text = rows[0];
  for (size_t i = 1; i + 20 <= rows.size(); i += 20) {
    for (size_t k = 0; k < 20; ++k) text += rows[i + (k + 10) % 20] + rows[i + (k + 10) % 20];
  }
  disk.write("imu0/data.csv", text + rows.back());
  const Recording sorted = open_recording(disk.folder(), {});
  ASSERT_EQ(sorted.imu.size(), whole.imu.size());
  for (size_t i = 0; i < whole.imu.size(); ++i) EXPECT_EQ(sorted.imu[i].t, whole.imu[i].t);
  EXPECT_EQ(sorted.counted("imu_rows_repeated"), 120u);
}

TEST(recording, stamps_in_any_unit_are_one_recording) {
  const Recording whole = open_recording(TestRecording().folder(), {});
  // What is written for a stamp of the test recording, all of whose stamps are whole milliseconds.
  const auto written = [](long long ns, int form) {
    const std::string ms = std::to_string(ns / 1'000'000);
    const std::string s = ms.substr(0, ms.size() - 3) + "." + ms.substr(ms.size() - 3);
    const std::string forms[] = {ms + "000", ms, s, ms + "000000.0",
                                 ms.substr(0, 1) + "." + ms.substr(1) + "e+12"};
    return forms[form];
  };
  for (int form = 0; form < 5; ++form) {
    const TestRecording disk;
    for (const char* file : {"cam0/data.csv", "cam1/data.csv", "imu0/data.csv",
                             "state_groundtruth_estimate0/data.csv"}) {
      std::istringstream rows(disk.read(file));
      std::string text;
      for (std::string row; std::getline(rows, row);) {
        const size_t comma = row.find(',');
        if (row[0] != '#')
          row = written(std::stoll(row.substr(0, comma)), form) + row.substr(comma);
        text += row + "\n";
      }
      disk.write(file, text);
    }
    const Recording read = open_recording(disk.folder(), {});
    ASSERT_EQ(read.frames.size(), whole.frames.size()) << form;
    EXPECT_EQ(read.frames[3].t, whole.frames[3].t) << form;
    EXPECT_EQ(read.imu[5].t, whole.imu[5].t) << form;
    EXPECT_EQ(read.truth.poses[7].t, whole.truth.poses[7].t) << form;
    EXPECT_EQ(read.notes.empty(), form == 3) << form;  // nanoseconds need no word
    EXPECT_TRUE(read.rejected.empty());
  }
}

// Names with folders, stamps alone, no table at all: loggers do all of these.
TEST(recording, images_are_found_where_tables_do_not_say) {
  for (const int form : {0, 1, 2}) {
    const TestRecording disk;
    for (const std::string camera : {"cam0", "cam1"}) {
      std::istringstream rows(disk.read(camera + "/data.csv"));
      std::string text;
      for (std::string row; std::getline(rows, row);) {
        const size_t comma = row.find(',');
        if (row[0] == '#') continue;
        text += form == 0 ? row.substr(0, comma + 1) + camera + "/data/" + row.substr(comma + 1)
                          : row.substr(0, comma);
        text += "\n";
      }
      disk.write(camera + "/data.csv", text);
      if (form == 2) std::filesystem::remove(disk.path(camera + "/data.csv"));
    }
    const Recording recording = open_recording(disk.folder(), {});
    ASSERT_EQ(recording.frames.size(), size_t(TestRecording::kFrames)) << form;
    EXPECT_EQ(Player(recording).next()->present, 3) << form;
  }
}

TEST(recording, columns_of_the_imu_go_by_their_names) {
  const TestRecording disk;
  InputLog log;
  disk.write("imu0/data.csv",
             "#timestamp [ns],q_w,q_x,q_y,q_z,a_x [g],a_y [g],a_z [g],w_x [deg/s],w_y,w_z\n"
             "1500000000000000000,1,0,0,0,0.5,0,1,180,0,90\n"
             "1500000000005000000,1,0,0,0,0.5,0,1,180,0,90\n");
  const auto samples = read_imu_samples(disk.path("imu0/data.csv"), log);
  EXPECT_LT((samples[0].w_B - Vec3(M_PI, 0, M_PI / 2)).norm(), 1e-12);
  EXPECT_LT((samples[0].f_B - Vec3(0.5, 0, 1) * 9.80665).norm(), 1e-12);
  EXPECT_EQ(log.notes.size(), 3u);
  disk.write("imu0/data.csv",
             "t,orientation.x,orientation.y,orientation.z,x1,y1,z1,x2,y2,z2\n"
             "1500000000000000000,0,0,0,0,0,0,0,0,9.8\n");
  EXPECT_THROW(read_imu_samples(disk.path("imu0/data.csv"), log), InputError);
}

// Of a clock that counts from the start of its machine: few digits, and nanoseconds all the same.
TEST(recording, short_stamps_are_nanoseconds_where_the_rate_says_so) {
  const TestRecording disk;
  InputLog log;
  disk.write("imu0/data.csv",
             "t,w_x,w_y,w_z,a_x,a_y,a_z\n0,0,0,0,0,0,9.81\n5000176,0,0,0,0,0,9.81\n");
  EXPECT_EQ(read_imu_samples(disk.path("imu0/data.csv"), log).at(1).t, 5'000'176);
  disk.write("imu0/data.csv",
             "t,w_x,w_y,w_z,a_x,a_y,a_z\n922,0,0,0,0,0,9.81\n927,0,0,0,0,0,9.81\n");
  EXPECT_EQ(read_imu_samples(disk.path("imu0/data.csv"), log).at(0).t, 922'000'000);
}

TEST(recording, unequal_cameras_play_as_single_images) {
  const TestRecording disk;
  disk.replace("cam1/data.csv", "1500000000100000000,", "1500000000130000000,");
  const Recording recording = open_recording(disk.folder(), {});
  ASSERT_EQ(recording.frames.size(), size_t(TestRecording::kFrames) + 1);
  EXPECT_EQ(value(recording.rejected, "frames_without_left"), 1u);
  EXPECT_EQ(value(recording.rejected, "frames_without_right"), 1u);
  EXPECT_EQ(recording.frames[2].image[1], "");
  EXPECT_EQ(recording.frames[3].image[0], "");
}

TEST(recording, bad_calibrations_are_named) {
  const char* const cases[][3] = {
      {"resolution: [64, 48]", "resolution: [64]", "resolution"},
      {"resolution: [64, 48]", "resolution: [72, 48]", "size is not the calibration's"},
      {"resolution: [64, 48]", "resolution: [48, 64]", "width and height are exchanged"},
      {"radial-tangential", "scaramuzza", "unknown model 'scaramuzza'"},
      {"[-0.1, 0.01, 0.001, 0.002]", "[-0.1, 0.01]", "distortion_coefficients"},
      {"[50.0, 51.0,", "[.nan, 51.0,", "intrinsics"},
      {"data: [1, 0,", "data: [2, 0,", "not a rotation"},
      {"T_BS:", "{T_BS:", "not YAML"},
      {"[-0.1, 0.01, 0.001, 0.002]", "[-1.5, 0.01, 0.001, 0.002]", "distortion turns back"},
      {"rate_hz: 20", "timeshift_cam_imu: soon", "timeshift_cam_imu"},
      {"rate_hz: 20", "timeshift_cam_imu: 5", "time offset"},
      {"[50.0, 51.0, 31.5,", "[50.0, 51.0, 131.5,", "cam0: give cx"}};
  for (const auto& [from, to, says] : cases) {
    const TestRecording disk;
    disk.replace("cam0/sensor.yaml", from, to);
    disk.replace("cam1/sensor.yaml", from, to);
    PIRVS_EXPECT_SAYS(error_of(disk.folder()), says);
  }
}

TEST(recording, reads_a_kalibr_camchain) {
  const TestRecording disk;
  disk.write("chain.yaml",
             "cam0:\n  camera_model: pinhole\n  distortion_model: equidistant\n"
             "  distortion_coeffs: [0.1, 0.02, 0.003, 0.0004]\n  intrinsics: [40, 41, 30, 20]\n"
             "  resolution: [64, 48]\n  timeshift_cam_imu: -0.004\n  T_cam_imu:\n"
             "  - [0, -1, 0, 1]\n  - [1, 0, 0, 2]\n  - [0, 0, 1, 3]\n  - [0, 0, 0, 1]\n"
             "cam1:\n  camera_model: pinhole\n  distortion_model: radtan\n"
             "  distortion_coeffs: [0.1, 0.02, 0.003, 0.0004]\n  intrinsics: [40, 41, 30, 20]\n"
             "  resolution: [64, 48]\n  T_cn_cnm1:\n"
             "  - [1, 0, 0, -0.1]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n");
  RecordingOptions options;
  options.calibration = disk.path("chain.yaml");
  const Recording recording = open_recording(disk.folder(), options);
  const Calibration& calibration = recording.calibration;
  EXPECT_EQ(calibration.camera[0].model, CameraModel::kKannalaBrandt);
  EXPECT_EQ(calibration.camera[1].model, CameraModel::kPinholeRadtan);
  EXPECT_EQ(calibration.camera_time_offset_ns, -4'000'000);
  EXPECT_EQ(calibration.imu.gyro_noise, 1.0e-4);
  EXPECT_LT((calibration.camera[0].T_BC * Vec3(1, 2, 3)).norm(), 1e-12);  // the IMU's origin in C0
  const Vec3 p_C0C1 = calibration.camera[0].T_BC.inverse() * calibration.camera[1].T_BC.p;
  EXPECT_LT((p_C0C1 - Vec3(0.1, 0, 0)).norm(), 1e-12);
}

TEST(recording, reads_a_devices_own_calibration) {
  const TestRecording disk;
  const Calibration asl = open_recording(disk.folder(), {}).calibration;
  Text<kCalibrationTextMax> text;
  write_calibration(asl, text);
  disk.write("device.cfg", text.c_str());
  RecordingOptions options;
  options.calibration = disk.path("device.cfg");
  const Calibration device = open_recording(disk.folder(), options).calibration;
  EXPECT_EQ(device.camera[1].T_BC.p, asl.camera[1].T_BC.p);
  EXPECT_EQ(device.camera[0].fx, asl.camera[0].fx);
  EXPECT_EQ(device.imu.accel_walk, asl.imu.accel_walk);
  disk.write("device.cfg", std::string(text.c_str()) + "cam0.lens = 3\n");
  try {
    open_recording(disk.folder(), options);
    FAIL() << "a key that there is not";
  } catch (const InputError& error) {
    PIRVS_EXPECT_SAYS(std::string(error.what()), "device.cfg:20: no such key in a calibration");
  }
}

TEST(player, plays_the_pixels_in_order) {
  const TestRecording disk;
  const Recording recording = open_recording(disk.folder(), {});
  Player player(recording);
  int frames = 0;
  while (const StereoFrame* frame = player.next()) {
    ASSERT_EQ(frame->t, recording.frames[size_t(frames)].t);
    ASSERT_EQ(frame->present, 3);
    for (int c = 0; c < 2; ++c) {
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
          const int expected = ((y * 64 + x) * 7 + frames * 31 + c * 5) % 251;
          ASSERT_EQ(frame->image[c].row(y)[x], expected);
        }
      }
    }
    player.release(frame);
    ++frames;
  }
  EXPECT_EQ(frames, TestRecording::kFrames);
  for (const Count& count : player.rejected()) EXPECT_EQ(count.value, 0u) << count.name;
}

TEST(player, stops_in_the_middle) {
  const TestRecording disk;
  const Recording recording = open_recording(disk.folder(), {});
  Player player(recording);
  ASSERT_NE(player.next(), nullptr);
}

TEST(player, frames_held_out_of_order_keep_their_pixels) {
  const TestRecording disk;
  const Recording recording = open_recording(disk.folder(), {});
  Player player(recording);
  const StereoFrame* const first = player.next();
  const StereoFrame* const second = player.next();
  const int pixel = second->image[1].row(5)[7];
  player.release(first);
  size_t played = 2;
  while (const StereoFrame* const frame = player.next()) {
    EXPECT_NE(frame, second);
    EXPECT_EQ(frame->info[0].sequence, played++);
    player.release(frame);
  }
  EXPECT_EQ(second->t, recording.frames[1].t);
  EXPECT_EQ(second->image[1].row(5)[7], pixel);
}

TEST(player, images_that_cannot_be_read_are_left_out_and_counted) {
  const TestRecording disk;
  std::filesystem::remove(disk.image(0, 2));
  disk.truncate(disk.image(1, 3), 0.6);
  disk.truncate(disk.image(0, 4), 0.0);
  std::ofstream(disk.image(1, 5)) << "this is not a picture";
  cv::imwrite(disk.image(0, 6), cv::Mat(24, 32, CV_8UC1, cv::Scalar(9)));
  const Recording recording = open_recording(disk.folder(), {});
  Player player(recording);
  std::vector<int> present;
  while (const StereoFrame* const frame = player.next()) {
    present.push_back(frame->present);
    player.release(frame);
  }
  EXPECT_EQ(present, (std::vector<int>{3, 3, 2, 1, 2, 1, 2, 3, 3, 3, 3, 3}));
  EXPECT_EQ(value(player.rejected(), "images_missing"), 1u);
  EXPECT_EQ(value(player.rejected(), "images_cut_off"), 2u);
  EXPECT_EQ(value(player.rejected(), "images_undecodable"), 1u);
  EXPECT_EQ(value(player.rejected(), "images_of_wrong_size"), 1u);
}

TEST(player, a_jpeg_cut_off_is_left_out) {
  const TestRecording disk;
  cv::Mat picture(48, 64, CV_8UC1, cv::Scalar(100));
  disk.replace("cam0/data.csv", "1500000000050000000.png", "x.jpg");
  disk.replace("cam0/data.csv", "1500000000100000000.png", "y.jpg");
  cv::imwrite(disk.path("cam0/data/x.jpg"), picture);
  cv::imwrite(disk.path("cam0/data/y.jpg"), picture);
  disk.truncate(disk.path("cam0/data/y.jpg"), 0.9);
  const Recording recording = open_recording(disk.folder(), {});
  Player player(recording);
  std::vector<int> present;
  while (const StereoFrame* const frame = player.next()) {
    present.push_back(frame->present);
    player.release(frame);
  }
  EXPECT_EQ(present, (std::vector<int>{3, 3, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3}));
  EXPECT_EQ(value(player.rejected(), "images_cut_off"), 1u);
}

TEST(player, no_image_at_all_is_an_error) {
  const TestRecording disk;
  std::filesystem::remove_all(disk.path("cam0/data"));
  std::filesystem::remove_all(disk.path("cam1/data"));
  PIRVS_EXPECT_SAYS(error_of(disk.folder()), "no image can be read");
}

}  // namespace
}  // namespace pirvs::tools
