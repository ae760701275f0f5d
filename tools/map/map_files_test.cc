#include "tools/map/map_files.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>

#include "modules/testing.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

class MapFiles : public ::testing::Test {
 protected:
  MapFiles() { fs::create_directories(folder_); }
  ~MapFiles() override { fs::remove_all(folder_); }

  static std::unique_ptr<Map> with_points(int count) {
    auto map = std::make_unique<Map>();
    for (int i = 0; i < count; ++i) {
      Landmark& point = *map->landmarks.find(map->landmarks.acquire().value());
      point.p_W = Vec3(i, 2, 3);
      point.cov = Mat3::Identity() * 1e-4;
    }
    return map;
  }
  static size_t points_of(const std::string& path) {
    auto map = std::make_unique<Map>();
    read_map_file(path, [&](const MapSource& source) { return load_map(source, *map); });
    return map->landmarks.size();
  }

  std::string folder_ = fs::temp_directory_path() / ("pirvs_map_" + std::to_string(getpid()));
  std::string path_ = folder_ + "/hall.map";
};

TEST_F(MapFiles, AreTheOldOneOrTheNewOneWheneverTheWriterDies) {
  constexpr int kDeaths = 100;
  const auto small = with_points(1000), large = with_points(2000);
  write_map_file(path_, *small);
  pirvs::testing::Random random(3);
  int inside = 0;
  const auto began = std::chrono::steady_clock::now();
  write_map_file(path_, *large);
  const std::chrono::duration<double, std::micro> write_us =
      std::chrono::steady_clock::now() - began;
  for (int i = 0; i < kDeaths; ++i) {
    int writes[2];
    ASSERT_EQ(pipe(writes), 0);
    const pid_t writer = fork();
    ASSERT_GE(writer, 0);
    if (writer == 0) {
      for (;;) {
        write_map_file(path_, *large);
        if (write(writes[1], "", 1) != 1) _exit(1);
        write_map_file(path_, *small);
      }
    }
    char begun;
    ASSERT_EQ(read(writes[0], &begun, 1), 1);
    usleep(static_cast<useconds_t>(random.uniform(0, 2 * write_us.count())));
    kill(writer, SIGKILL);
    waitpid(writer, nullptr, 0);
    close(writes[0]);
    close(writes[1]);
    inside += fs::exists(path_ + ".part") ? 1 : 0;
    const size_t points = points_of(path_);
    ASSERT_TRUE(points == 1000 || points == 2000) << points;
  }
  EXPECT_GT(inside, kDeaths / 10) << "some died in the midst of writing";
}

TEST_F(MapFiles, TellWhatIsWrong) {
  const auto message = [&](const std::string& path) -> std::string {
    try {
      (void)points_of(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(folder_ + "/none.map").find("cannot open the map"), std::string::npos);
  std::ofstream(path_) << "no map at all";
  EXPECT_NE(message(path_).find("not a map of this version, or damaged"), std::string::npos);
  try {
    write_map_file(folder_ + "/no/such/folder.map", *with_points(1));
    FAIL() << "it was written";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot write the map"), std::string::npos);
  }
}

}  // namespace
}  // namespace pirvs::tools
