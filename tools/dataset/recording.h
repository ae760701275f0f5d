// What    What a recorded folder holds: calibration, frames (file names), IMU samples, the truth.
// In      An ASL/EuRoC folder, or its mav0, or a file that `pirvs pack` wrote. cam0, imu0 are
//         needed; cam1, gnss0 and state_groundtruth_estimate0 (or groundtruth.tum) are used if they
//         are there.
// Out     Frames and samples in order of time, or, where the recording has an order.csv, all of
//         them in the order in which they came. A frame whose partner is missing stays, alone.
// Frames  B = the IMU.
// Units   t in ns, each sensor's own stamps; rad/s, m/s^2.
// Errors  InputError: a needed file is missing or unreadable, a line is not data, no frames, a
//         calibration that makes no sense. Rejected and counted by name: rows cut off, not finite,
//         not after the row before.
// Cost    ~30 ms for a minute of EuRoC; images are opened by the player, not here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "core/kernels/image.h"
#include "modules/calibration/calibration.h"
#include "modules/recorder/order_row.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct FrameFiles {
  TimeNs t = 0;
  std::string image[2];  // empty: that camera has no image at t
  ImageView pixels[2];   // of a packed recording, which has no image files
  TimeNs late[2] = {0, 0};
  uint32_t lost_before = 0;  // frames that the driver lost
};

struct Count {
  std::string name;
  size_t value = 0;
};

struct RecordingOptions {
  std::string calibration;  // for read_calibration_file; empty: the folder's own sensor.yaml files
  double start_s = 0;       // skip this much, from the first frame
  double duration_s = 0;    // 0: to the end
  bool mono = false;        // the left camera alone, whatever was recorded
  std::string gnss;         // for read_gnss; empty: the folder's own
  std::string wheels;       // for read_wheels, sensor.yaml beside it; empty: the folder's own
};

struct Recording {
  std::string folder;
  Calibration calibration;
  std::vector<FrameFiles> frames;
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
  bool gnss_apart = false;  // they do not stand in `order`
  GnssSensor gnss_sensor;
  std::vector<WheelSample> wheels;
  bool wheels_apart = false;  // they do not stand in `order`
  // As the recorder wrote it, in which case frames and samples are all that came, whatever their
  // stamps; else empty. Only of a whole recording, not of a part.
  std::vector<OrderRow> order;
  // With it: up to which keyframe mapping had come when each frame began.
  std::vector<uint32_t> maps;
  Trajectory truth;  // no poses: the recording has none
  std::vector<Count> rejected;
  std::shared_ptr<const void> pack;  // the memory that FrameFiles::pixels point into

  double duration_s() const;
};

// The tables that a recording is made of, each alone.
struct ListedImage {
  TimeNs t = 0;
  std::string file;
};
// kAsRecorded: rows that go back in time or are not finite are what was sensed, and stay.
enum class Rows : uint8_t { kInOrderOfTime, kAsRecorded };
std::vector<ListedImage> read_image_list(const std::string& path, std::vector<Count>& rejected,
                                         Rows rows = Rows::kInOrderOfTime);
std::vector<ImuSample> read_imu_samples(const std::string& path, std::vector<Count>& rejected,
                                        Rows rows = Rows::kInOrderOfTime);

Recording open_recording(const std::string& folder, const RecordingOptions& options);

}  // namespace pirvs::tools
