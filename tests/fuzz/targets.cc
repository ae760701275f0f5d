#include "tests/fuzz/targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <iterator>
#include <string>

#include "core/base/assert.h"
#include "modules/app/calibration_check.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording.h"
#include "tools/dataset/trajectory.h"
#include "tools/run/fault.h"
#include "tools/run/parameters.h"

namespace pirvs::fuzz {
namespace {

using tools::InputError;

// The bytes as a file that needs no disk.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* data, size_t size) : fd_(memfd_create("fuzz", MFD_CLOEXEC)) {
    PIRVS_ASSERT(fd_ >= 0 && write(fd_, data, size) == ssize_t(size));
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

// Every refusal is one line.
template <class Parse>
void expect_result_or_refusal(Parse&& parse) {
  try {
    parse();
  } catch (const InputError& error) {
    PIRVS_ASSERT(std::strlen(error.what()) > 0);
  }
}

void imu_csv(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    std::vector<tools::Count> rejected;
    const auto samples = tools::read_imu_samples(file.path(), rejected);
    PIRVS_ASSERT(!samples.empty());
    for (size_t i = 0; i < samples.size(); ++i) {
      PIRVS_ASSERT(samples[i].w_B.allFinite() && samples[i].f_B.allFinite());
      PIRVS_ASSERT(i == 0 || samples[i].t > samples[i - 1].t);
    }
  });
}

void image_list(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    std::vector<tools::Count> rejected;
    const auto images = tools::read_image_list(file.path(), rejected);
    PIRVS_ASSERT(!images.empty());
    for (size_t i = 1; i < images.size(); ++i) PIRVS_ASSERT(images[i].t > images[i - 1].t);
  });
}

void expect_usable(const Calibration& calibration) {
  const CalibrationFault fault = find_fault(calibration);
  if (fault) return;
  for (int c = 0; c < calibration.cameras; ++c) {
    Vec2 uv;
    const Camera& camera = calibration.camera[c];
    PIRVS_ASSERT(camera.project(Vec3(0, 0, 1), uv) && uv.allFinite());
  }
}

void sensor_yaml(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    Calibration calibration;
    calibration.cameras = 1;
    TimeNs offset = 0;
    calibration.camera[0] = tools::read_asl_camera(file.path(), offset);
    calibration.camera_time_offset = offset;
    expect_usable(calibration);
  });
  expect_result_or_refusal([&] { (void)tools::read_imu_noise(file.path()); });
}

void kalibr_yaml(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal(
      [&] { expect_usable(tools::read_kalibr_calibration(file.path(), ImuNoise{})); });
}

void trajectory(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    const tools::Trajectory read = tools::read_trajectory(file.path());
    PIRVS_ASSERT(!read.poses.empty());
    for (const tools::TrajectoryPose& pose : read.poses) {
      PIRVS_ASSERT(pose.p_WB.allFinite() && std::abs(pose.q_WB.norm() - 1) < 1e-6);
      PIRVS_ASSERT(!tools::tum_line(pose.t, pose.p_WB, pose.q_WB).empty());
    }
  });
}

void parameter(const uint8_t* data, size_t size) {
  const std::string assignment(reinterpret_cast<const char*>(data), size);
  expect_result_or_refusal([&] {
    AppParams params;
    tools::set_parameter(params, assignment);
    PIRVS_ASSERT(!tools::list_parameters(params).empty());
  });
}

void fault(const uint8_t* data, size_t size) {
  const std::string spec(reinterpret_cast<const char*>(data), size);
  expect_result_or_refusal([&] {
    const tools::Fault fault = tools::parse_fault(spec);
    PIRVS_ASSERT(fault.kind < tools::FaultKind::kCount && std::isfinite(fault.value));
    PIRVS_ASSERT(fault.begin >= 0 && fault.end > fault.begin);
  });
}

}  // namespace

const Target kTargets[] = {
    {"imu_csv", imu_csv},
    {"image_list", image_list},
    {"sensor_yaml", sensor_yaml},
    {"kalibr_yaml", kalibr_yaml},
    {"trajectory", trajectory},
    {"parameter", parameter},
    {"fault", fault},
};
const size_t kTargetCount = std::size(kTargets);

const Target* find_target(const char* name) {
  for (const Target& target : kTargets) {
    if (std::strcmp(name, target.name) == 0) return &target;
  }
  return nullptr;
}

}  // namespace pirvs::fuzz
