// What    Reads a log of ROS messages into a Recording.
// In      A LogFile; a calibration (--calib), since a log says nothing of the IMU and the cameras
//         together; topics, where several would do.
// Out     recording. Cameras: topics of images, as the calibration's rostopic or options name them,
//         else in the order of their names, two of about one rate. IMU: one topic, or a gyro's and
//         an accelerometer's, of which the force is interpolated. Truth: odometry or poses.
// Units, errors  as of recording.h. What was chosen is noted.
// Cost    one scan of the log; images are unpacked by the player.
// Source  docs/formats.md.
#pragma once

#include "tools/dataset/logs/log_file.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

void read_log(std::unique_ptr<LogFile> log, const std::string& path,
              const RecordingOptions& options, Recording& recording);

}  // namespace pirvs::tools
