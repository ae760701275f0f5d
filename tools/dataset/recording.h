// What    What a recording holds: calibration, frames (where their images are), IMU samples, truth.
// In      An ASL/EuRoC folder, or its mav0, or one of its dialects; a file that `pirvs pack` wrote.
//         cam0, imu0 are needed; cam1, gnss0 and a truth are used if they are there
//         (docs/formats.md).
// Out     Frames and samples in order of time, or, where the recording has an order.csv, all of
//         them in the order in which they came. A frame whose partner is missing stays, alone.
// Frames  B = the IMU. Images, before they are turned as `turns` says, as the files have them.
// Units   t in ns, each sensor's own stamps; rad/s, m/s^2.
// Errors  InputError: a needed file is missing or unreadable, a line is not data, no frames, a
//         calibration that makes no sense. Counted by name, and noted: what input_log.h says.
// Cost    ~60 ms for a minute of EuRoC; images are opened by the player, not here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "core/kernels/image.h"
#include "modules/calibration/calibration.h"
#include "modules/recorder/order_row.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_log.h"
#include "tools/dataset/stamps.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

class ImageStore;

struct FrameFiles {
  TimeNs t = 0;
  std::string image[2];  // empty: that camera has no image at t
  ImageView pixels[2];   // of a packed recording, which has no image files
  TimeNs late[2] = {0, 0};
  uint32_t lost_before = 0;  // frames that the driver lost
};

struct RecordingOptions {
  std::string calibration;   // for read_rig; empty: the recording's own
  std::string imu;           // noise densities instead of the calibration's
  std::vector<int> cameras;  // left and right, as numbered in the recording; empty: 0 and 1
  StampUnit stamps = StampUnit::kUnknown;
  double late_s = 0;                // the cameras' stamps, against what the calibration says
  std::vector<std::string> topics;  // of a log, where several would do
  double start_s = 0;               // skip this much, from the first frame
  double duration_s = 0;            // 0: to the end
  bool mono = false;                // the left camera alone, whatever was recorded
  std::string gnss;                 // for read_gnss; empty: the folder's own
  std::string wheels;  // for read_wheels, sensor.yaml beside it; empty: the folder's own
};

struct Recording : InputLog {
  std::string folder;
  std::string kind = "ASL folder";
  Calibration calibration;
  int turns[2] = {0, 0};  // quarter turns, clockwise, of each camera's images
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
  Trajectory truth;                   // no poses: the recording has none
  std::shared_ptr<const void> pack;   // the memory that FrameFiles::pixels point into
  std::shared_ptr<ImageStore> store;  // what FrameFiles::image names; null: files

  double duration_s() const;
};

Recording open_recording(const std::string& path, const RecordingOptions& options);

}  // namespace pirvs::tools
