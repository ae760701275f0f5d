#include "tools/dataset/recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "tools/dataset/asl_folder.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/log_recording.h"
#include "tools/dataset/loose_files.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kImuMargin = 50'000'000;  // IMU kept around a cut-out, to interpolate at its ends

void cut(const RecordingOptions& options, Recording& recording) {
  if (options.start_s <= 0 && options.duration_s <= 0) return;
  auto& frames = recording.frames;
  const TimeNs begin = frames.front().t + from_seconds(options.start_s);
  const TimeNs end = options.duration_s > 0 ? begin + from_seconds(options.duration_s) : INT64_MAX;
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const FrameFiles& f) { return f.t < begin || f.t > end; }),
               frames.end());
  if (frames.empty()) {
    throw InputError("no frames between --start and --duration", recording.folder,
                     "choose a shorter --start");
  }
  const TimeNs offset = recording.calibration.camera_time_offset_ns;
  const TimeNs imu_begin = frames.front().t + offset - kImuMargin;
  const TimeNs imu_end = frames.back().t + offset + kImuMargin;
  const auto keep_between = [&](auto& samples) {
    samples.erase(std::remove_if(samples.begin(), samples.end(),
                                 [&](const auto& s) { return s.t < imu_begin || s.t > imu_end; }),
                  samples.end());
  };
  keep_between(recording.gnss);
  keep_between(recording.wheels);
  keep_between(recording.imu);
}

void check_overlap(const Recording& recording) {
  const TimeNs offset = recording.calibration.camera_time_offset_ns;
  if (!recording.imu.empty() && recording.imu.front().t <= recording.frames.back().t + offset &&
      recording.imu.back().t >= recording.frames.front().t + offset) {
    return;
  }
  char spans[160] = "";
  if (!recording.imu.empty()) {
    std::snprintf(spans, sizeof spans, " (images %.3f to %.3f s, IMU %.3f to %.3f s)",
                  to_seconds(recording.frames.front().t), to_seconds(recording.frames.back().t),
                  to_seconds(recording.imu.front().t), to_seconds(recording.imu.back().t));
  }
  throw InputError("images and IMU do not overlap in time" + std::string(spans), recording.folder,
                   "both need stamps of one clock; --stamps says what they count");
}

// What was counted and is more than a row or two, in words.
void note_counts(Recording& recording) {
  struct Kind {
    const char *rows, *what;
    size_t of;
  };
  const size_t images = recording.frames.size(), samples = recording.imu.size();
  const Kind kinds[] = {{"imu_rows_out_of_order", "IMU rows were out of order: sorted", samples},
                        {"imu_rows_repeated", "IMU rows repeat a stamp: left out", samples},
                        {"imu_samples_not_finite", "IMU rows are not finite: left out", samples},
                        {"image_rows_out_of_order", "image rows were out of order: sorted", images},
                        {"image_rows_repeated", "image rows repeat a stamp: left out", images},
                        {"frames_without_left", "frames have no left image", images},
                        {"frames_without_right", "frames have no right image", images}};
  constexpr size_t kPart = 100;  // below one in a hundred it goes without a word
  for (const Kind& kind : kinds) {
    const size_t n = recording.counted(kind.rows);
    if (n * kPart > kind.of) {
      recording.note(std::to_string(n) + " of " + std::to_string(kind.of) + " " + kind.what);
    }
  }
}

bool is_asl(const std::string& path) {
  return fs::is_directory(path + "/mav0") || fs::is_directory(path + "/imu0");
}

}  // namespace

double Recording::duration_s() const {
  return frames.empty() ? 0 : to_seconds(frames.back().t - frames.front().t);
}

Recording open_recording(const std::string& path, const RecordingOptions& options) {
  Recording recording;
  if (!fs::exists(path)) {
    throw InputError(
        "no such recording", path,
        "give an ASL/EuRoC folder, a ROS bag, a rosbag2 folder, an MCAP file, a folder "
        "with a video or images and tables, or a packed file");
  }
  recording.folder = path;
  if (auto log = open_log(path)) {
    read_log(std::move(log), path, options, recording);
  } else if (!is_asl(path) && is_loose(path)) {
    read_loose_files(path, options, recording);
  } else if (fs::is_directory(path)) {
    read_asl_folder(path, options, recording);
  } else {
    if (!options.calibration.empty()) {
      throw InputError("a packed recording has its own calibration", path, "leave out --calib");
    }
    recording = open_pack(path);
  }
  // For stamps that are this much later than the calibration says.
  recording.calibration.camera_time_offset_ns -= from_seconds(options.late_s);
  cut(options, recording);
  check_overlap(recording);
  note_counts(recording);
  return recording;
}

}  // namespace pirvs::tools
