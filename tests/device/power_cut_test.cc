// The power goes while a device records: what lies on the disk is whole up to the last second.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/device/guest_run.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/player.h"

namespace pirvs::systems {
namespace {

constexpr uintmax_t kDiskBytes = 512 << 20;

TEST(device_power, a_recording_is_whole_up_to_the_last_second_when_it_goes) {
  GuestSetup setup;
  setup.name = "device_power";
  setup.record = false;
  setup.cut_s = 7.3;
  setup.disk = scratch_folder("power") + "/disk";
  std::ofstream(setup.disk).close();
  std::filesystem::resize_file(setup.disk, kDiskBytes);
  ASSERT_EQ(std::system(("/sbin/mkfs.ext4 -q -F " + setup.disk).c_str()), 0);
  const DeviceRun run = run_guest(fed_recording(), setup);
  const size_t at = run.console.find("cut at ");
  ASSERT_NE(at, std::string::npos) << run.console;
  const TimeNs cut = from_seconds(std::atof(run.console.c_str() + at + 7));

  // What a PC does with such a card: the journal is played, then files are read. 1: it was.
  const int checked =
      std::system(("/sbin/e2fsck -fy " + setup.disk + " > " + run.folder + "/e2fsck 2>&1").c_str());
  EXPECT_LE(checked >> 8, 1) << text_of(run.folder + "/e2fsck");
  ASSERT_EQ(std::system(("/sbin/debugfs -R 'rdump /record " + run.folder + "' " + setup.disk +
                         " > " + run.folder + "/debugfs 2>&1")
                            .c_str()),
            0);
  const tools::Recording left = tools::open_recording(run.folder + "/record/0001", {});
  constexpr TimeNs kLost_max = 1'700'000'000;  // rows wait 0.5 s, the disk a second, and writes
  std::printf("cut at %.3f s; samples to %.3f s before it, images to %.3f s\n", to_seconds(cut),
              to_seconds(cut - left.imu.back().t), to_seconds(cut - left.frames.back().t));
  EXPECT_LT(cut - left.imu.back().t, kLost_max);
  EXPECT_LT(cut - left.frames.back().t, kLost_max);
  size_t whole = 0, images = 0;
  for (const auto& frame : left.frames) {
    for (const std::string& path : frame.image) {
      ++images;
      const Camera& camera = left.calibration.camera[0];
      const auto pixels = static_cast<uintmax_t>(camera.width * camera.height);
      std::error_code none;
      whole += std::filesystem::file_size(path, none) > pixels && !none;
    }
  }
  std::printf("%zu of %zu listed images are whole\n", whole, images);
  EXPECT_GE(whole + 2, images) << "a last pair at most was on its way";
  const Replay again = replay(left);
  print("replay of what was left", again);
  EXPECT_GT(again.result.trajectory.poses.size(), left.frames.size() / 2);
}

}  // namespace
}  // namespace pirvs::systems
