#include "tools/dataset/recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tools/dataset/calibration_file.h"
#include "tools/dataset/gnss_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/order_file.h"
#include "tools/dataset/pack_file.h"
#include "tools/dataset/text_table.h"
#include "tools/dataset/wheel_file.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kPairing = 1'000'000;     // one trigger: stamps of a pair are this close
constexpr TimeNs kImuMargin = 50'000'000;  // IMU kept around a cut-out, to interpolate at its ends

void count(std::vector<Count>& counts, const char* name, size_t value = 1) {
  for (Count& c : counts) {
    if (c.name == name) {
      c.value += value;
      return;
    }
  }
  counts.push_back({name, value});
}

std::vector<ListedImage> read_images(const std::string& camera_folder, Recording& recording) {
  const Rows rows = recording.order.empty() ? Rows::kInOrderOfTime : Rows::kAsRecorded;
  auto images = read_image_list(camera_folder + "/data.csv", recording.rejected, rows);
  for (ListedImage& image : images) image.file.insert(0, camera_folder + "/data/");
  return images;
}

void read_frames(const std::string& mav0, Recording& recording) {
  const std::vector<ListedImage> left = read_images(mav0 + "/cam0", recording);
  std::vector<ListedImage> right;
  if (recording.calibration.cameras == 2) right = read_images(mav0 + "/cam1", recording);
  size_t i = 0;
  size_t j = 0;
  while (i < left.size() || j < right.size()) {
    const TimeNs t_left = i < left.size() ? left[i].t : INT64_MAX;
    const TimeNs t_right = j < right.size() ? right[j].t : INT64_MAX;
    const bool use_left = t_left <= t_right || t_left - t_right <= kPairing;
    const bool use_right = t_right <= t_left || t_right - t_left <= kPairing;
    FrameFiles frame;
    frame.t = use_left ? t_left : t_right;
    if (use_left) frame.image[0] = left[i++].file;
    if (use_right) frame.image[1] = right[j++].file;
    if (!use_left) count(recording.rejected, "frames_without_left");
    if (!use_right && recording.calibration.cameras == 2)
      count(recording.rejected, "frames_without_right");
    recording.frames.push_back(frame);
  }
}

// Each frame's images are the next ones of the cameras that it says are present. What the tables
// do not hold any more, as after a power cut, has not come.
void read_frames_in_order(const std::string& mav0, Recording& recording) {
  std::vector<ListedImage> images[2];
  for (int c = 0; c < recording.calibration.cameras; ++c) {
    images[c] = read_images(mav0 + "/cam" + std::to_string(c), recording);
  }
  size_t image_at[2] = {0, 0}, imu = 0, row = 0;
  for (bool whole = true; row < recording.order.size(); ++row) {
    const OrderRow& order = recording.order[row];
    if (order.kind == ArrivalKind::kImu) whole = imu++ < recording.imu.size();
    FrameFiles frame;
    for (int c = 0; order.kind == ArrivalKind::kFrame && c < recording.calibration.cameras; ++c) {
      frame.late[c] = order.late[c];
      if ((order.present >> c & 1) == 0) continue;
      whole = whole && image_at[c] < images[c].size();
      if (whole) frame.image[c] = images[c][image_at[c]++].file;
    }
    if (!whole) break;
    frame.t = order.t;
    frame.lost_before = order.lost_before;
    if (order.kind == ArrivalKind::kFrame) recording.frames.push_back(frame);
  }
  recording.order.resize(row);
}

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

// Of a file, of gnss0, or as the recorder wrote them among all that came.
void read_fixes(const std::string& mav0, const RecordingOptions& options, Recording& recording) {
  const std::string beside = fs::path(options.gnss).parent_path().string();
  const bool own = options.gnss.empty() || !fs::exists(beside + "/sensor.yaml");
  const std::string folder = own ? mav0 + "/gnss0" : beside;
  if (fs::exists(folder + "/sensor.yaml")) {
    recording.gnss_sensor = read_gnss_sensor(folder + "/sensor.yaml");
    if (!own) recording.calibration.gnss = recording.gnss_sensor.antenna;
  }
  const std::string file = options.gnss.empty() ? folder + "/data.csv" : options.gnss;
  if (!options.gnss.empty() || fs::exists(file)) {
    recording.gnss = read_gnss(file, gnss_format(file), recording.rejected);
    recording.gnss_apart = true;
    return;
  }
  for (const OrderRow& row : recording.order) {
    if (row.kind == ArrivalKind::kGnss) recording.gnss.push_back(row.gnss);
  }
}

void read_wheels(const std::string& mav0, const RecordingOptions& options, Recording& recording) {
  const bool own = options.wheels.empty();
  const std::string file = own ? mav0 + "/wheel0/data.csv" : options.wheels;
  if (own && !fs::exists(file)) {
    for (const OrderRow& row : recording.order) {
      if (row.kind == ArrivalKind::kWheel) recording.wheels.push_back(row.wheel);
    }
    return;
  }
  const std::string yaml = (fs::path(file).parent_path() / "sensor.yaml").string();
  const WheelSensor sensor = read_wheel_sensor(yaml);
  if (!own) recording.calibration.wheels = sensor.calibration;
  recording.wheels = read_wheels(file, sensor.kind, recording.rejected);
  recording.wheels_apart = true;
}

void check_overlap(const Recording& recording) {
  const TimeNs offset = recording.calibration.camera_time_offset_ns;
  if (recording.imu.empty() || recording.imu.front().t > recording.frames.back().t + offset ||
      recording.imu.back().t < recording.frames.front().t + offset) {
    throw InputError("images and IMU do not overlap in time", recording.folder,
                     "both need stamps of one clock in ns");
  }
}

}  // namespace

std::vector<ListedImage> read_image_list(const std::string& path, std::vector<Count>& rejected,
                                         Rows rows) {
  TextTable table(path, "list of images");
  std::vector<ListedImage> images;
  while (table.next()) {
    const auto t = table.stamp();
    if (!t || table.columns() < 2) {
      if (!table.cut_off()) table.fail("needs 'stamp,file name'", "remove or repair the line");
      count(rejected, "image_rows_truncated");
    } else if (rows == Rows::kInOrderOfTime && !images.empty() && *t <= images.back().t) {
      count(rejected, "image_stamps_not_rising");
    } else {
      images.push_back({*t, std::string(table.text(1))});
    }
  }
  if (images.empty()) throw InputError("no images listed", path, "check the recording");
  return images;
}

std::vector<ImuSample> read_imu_samples(const std::string& path, std::vector<Count>& rejected,
                                        Rows rows) {
  TextTable table(path, "IMU samples");
  std::vector<ImuSample> samples;
  constexpr size_t kValues = 6;
  while (table.next()) {
    const auto t = table.stamp();
    double v[kValues] = {};
    bool complete = t && table.columns() > kValues;
    bool finite = true;
    for (size_t k = 0; k < kValues && complete; ++k) {
      const auto value = table.number(k + 1);
      complete = value.has_value();
      v[k] = value.value_or(0);
      finite = finite && std::isfinite(v[k]);
    }
    if (!complete) {
      if (!table.cut_off()) table.fail("needs 7 numbers", "remove or repair the line");
      count(rejected, "imu_rows_truncated");
    } else if (rows == Rows::kAsRecorded) {
      samples.push_back({*t, Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])});
    } else if (!finite) {
      count(rejected, "imu_samples_not_finite");
    } else if (!samples.empty() && *t <= samples.back().t) {
      count(rejected, "imu_stamps_not_rising");
    } else {
      samples.push_back({*t, Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])});
    }
  }
  if (samples.empty()) {
    throw InputError("no IMU samples", path, "check the recording");
  }
  return samples;
}

double Recording::duration_s() const {
  return frames.empty() ? 0 : to_seconds(frames.back().t - frames.front().t);
}

Recording open_recording(const std::string& folder, const RecordingOptions& options) {
  if (fs::is_regular_file(folder)) {
    if (!options.calibration.empty()) {
      throw InputError("a packed recording has its own calibration", folder, "leave out --calib");
    }
    Recording recording = open_pack(folder);
    cut(options, recording);
    check_overlap(recording);
    return recording;
  }
  if (!fs::is_directory(folder)) {
    throw InputError("no such recording", folder, "give an ASL/EuRoC folder or a packed file");
  }
  const std::string mav0 = fs::is_directory(folder + "/mav0") ? folder + "/mav0" : folder;
  if (!fs::is_directory(mav0 + "/cam0")) {
    throw InputError("not a recording, it has no cam0", mav0, "give an ASL/EuRoC folder");
  }
  Recording recording;
  recording.folder = folder;
  if (options.calibration.empty()) {
    recording.calibration = read_asl_calibration(mav0);
  } else {
    const std::string own = mav0 + "/imu0/sensor.yaml";
    const ImuNoise noise = fs::exists(own) ? read_imu_noise(own) : ImuNoise{};
    recording.calibration = read_calibration_file(options.calibration, noise);
  }
  if (options.mono || !fs::is_directory(mav0 + "/cam1")) recording.calibration.cameras = 1;
  check_sense(recording.calibration, options.calibration.empty() ? mav0 : options.calibration);
  const bool whole = options.start_s <= 0 && options.duration_s <= 0;
  if (whole && fs::exists(mav0 + "/order.csv")) recording.order = read_order(mav0 + "/order.csv");
  const bool ordered = !recording.order.empty();
  if (ordered && fs::exists(mav0 + "/maps.csv")) recording.maps = read_maps(mav0 + "/maps.csv");
  recording.imu = read_imu_samples(mav0 + "/imu0/data.csv", recording.rejected,
                                   ordered ? Rows::kAsRecorded : Rows::kInOrderOfTime);
  if (ordered) {
    read_frames_in_order(mav0, recording);
    if (recording.frames.empty()) throw InputError("no frames", mav0, "check the recording");
  } else {
    read_frames(mav0, recording);
  }
  read_fixes(mav0, options, recording);
  read_wheels(mav0, options, recording);
  cut(options, recording);
  check_overlap(recording);
  for (const char* name : {"/state_groundtruth_estimate0/data.csv", "/groundtruth.tum"}) {
    if (recording.truth.poses.empty() && fs::exists(mav0 + name)) {
      recording.truth = read_trajectory(mav0 + name);
      if (recording.truth.rows_truncated > 0) count(recording.rejected, "truth_rows_truncated");
    }
  }
  return recording;
}

}  // namespace pirvs::tools
