// A recording as an MCAP file, its calibration beside it.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "modules/calibration/calibration_text.h"
#include "tools/convert/image_files.h"
#include "tools/convert/writers.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/mcap_writer.h"
#include "tools/dataset/logs/ros_writer.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

// A part of the truth and of the samples goes out before each frame.
class Mixed {
 public:
  Mixed(const Recording& recording, McapWriter& file)
      : recording_(recording), file_(file), imu_(file.add_channel("/imu0", kRosImu)) {
    if (!recording.truth.poses.empty()) pose_ = file.add_channel("/pose", kRosPose);
  }
  void write_until(TimeNs t) {
    const auto& imu = recording_.imu;
    for (; i_ < imu.size() && imu[i_].t <= t; ++i_) {
      file_.write(imu_, imu[i_].t, ros_imu(imu[i_], "imu0").bytes());
    }
    const auto& poses = recording_.truth.poses;
    for (; j_ < poses.size() && poses[j_].t <= t; ++j_) {
      const TrajectoryPose& pose = poses[j_];
      file_.write(pose_, pose.t, ros_pose(pose.t, "world", pose.p_WB, pose.q_WB).bytes());
    }
  }

 private:
  const Recording& recording_;
  McapWriter& file_;
  McapWriter::Channel imu_, pose_ = 0;
  size_t i_ = 0, j_ = 0;
};

void write_messages(const Recording& recording, std::ostream& out, const FrameDone& done,
                    InputLog& log) {
  McapWriter file(out);
  Mixed rest(recording, file);
  McapWriter::Channel camera[2] = {0, 0};
  for (int c = 0; c < recording.calibration.cameras; ++c) {
    camera[c] = file.add_channel("/cam" + std::to_string(c) + "/image_raw/compressed", kRosImage);
  }
  ImageFiles images(recording, true);
  for (size_t i = 0; i < recording.frames.size(); ++i) {
    const TimeNs t = recording.frames[i].t;
    EncodedImage image[2];
    images.next(image);
    rest.write_until(t);
    for (int c = 0; c < recording.calibration.cameras; ++c) {
      if (image[c].format.empty()) continue;
      const std::string frame = "cam" + std::to_string(c);
      file.write(camera[c], t, ros_image(t, frame, image[c].format, image[c].bytes).bytes());
    }
    done(i + 1);
  }
  rest.write_until(INT64_MAX);
  file.finish();
  for (const Count& count : images.rejected()) log.count(count.name, count.value);
}

void write_calibration_file(const Calibration& calibration, const std::string& path) {
  Text<kCalibrationTextMax> text;
  write_calibration(calibration, text);
  std::ofstream file(path, std::ios::binary);
  file << "# What was recorded beside it; pirvs takes it by its name.\n" << text.c_str();
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

}  // namespace

void write_mcap(const Recording& recording, const std::string& out, const FrameDone& done,
                InputLog& log) {
  const std::string calibration = fs::path(out).replace_extension(".cfg").string();
  for (const std::string& path : {out, calibration}) {
    if (fs::exists(path)) throw InputError("is there already", path, "choose another OUT");
  }
  const std::string part = out + ".part";
  std::ofstream file(part, std::ios::binary);
  const auto give_up = [&] {
    std::error_code error;
    fs::remove(part, error);
  };
  try {
    write_messages(recording, file, done, log);
    file.close();
    if (!file) throw InputError("cannot write", out, "check space and permissions");
    write_calibration_file(recording.calibration, calibration);
  } catch (...) {
    give_up();
    throw;
  }
  std::error_code error;
  fs::rename(part, out, error);
  if (error) throw InputError("cannot write", out, "check space and permissions");
  const size_t left_out = recording.gnss.size() + recording.wheels.size();
  if (left_out > 0) {
    log.note(std::to_string(left_out) + " rows of GNSS and wheels are left out of an MCAP file");
  }
  if (recording.truth.full_state) {
    log.note("velocities and biases of the truth are left out of an MCAP file");
  }
}

}  // namespace pirvs::tools
