#include "tools/dataset/loose_files.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>

#include "tools/dataset/assemble.h"
#include "tools/dataset/image_size.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/loose_tables.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/dataset/text_table.h"
#include "tools/dataset/video_images.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using Table = std::unique_ptr<TextTable>;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool has_extension(const fs::path& path, std::initializer_list<const char*> extensions) {
  const std::string own = lower(path.extension().string());
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const char* one) { return own == one; });
}
bool is_video(const fs::path& path) {
  return has_extension(path, {".mp4", ".mov", ".avi", ".mkv", ".m4v", ".webm"});
}
bool is_image(const fs::path& path) {
  return has_extension(path, {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"});
}
bool is_table(const fs::path& path) { return has_extension(path, {".csv", ".txt", ".tum"}); }

// What a folder holds, by the names.
struct Files {
  Names videos, images;  // images: folders
  Names tables;
  std::string imu, gyro, accel, truth;
  std::string stamps[2];  // of each camera
};

// In the order of their names; none of a file.
Names images_in(const fs::path& folder) {
  Names out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (is_image(entry.path())) out.push_back(entry.path().string());
  }
  std::sort(out.begin(), out.end());
  return out;
}

Files list(const std::string& folder) {
  Files out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (entry.is_directory()) {
      if (!images_in(path).empty()) out.images.push_back(path);
    } else if (is_video(path)) {
      out.videos.push_back(path);
    } else if (is_table(path)) {
      out.tables.push_back(path);
    }
  }
  if (out.images.empty() && !images_in(folder).empty()) out.images.push_back(folder);
  for (Names* names : {&out.videos, &out.images, &out.tables}) {
    std::sort(names->begin(), names->end());
  }
  return out;
}

const Names& cameras_of(const Files& files) {
  return files.videos.empty() ? files.images : files.videos;
}

void tell_tables(Files& files) {
  const Names& cameras = cameras_of(files);
  for (const std::string& table : files.tables) {
    const std::string name = lower(fs::path(table).stem().string());
    const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
    const auto take = [&](std::string& as) { as = as.empty() ? table : as; };
    bool of_camera = false;
    for (size_t c = 0; c < std::min<size_t>(2, cameras.size()); ++c) {
      if (name != lower(fs::path(cameras[c]).stem().string())) continue;
      files.stamps[c] = table;
      of_camera = true;
    }
    if (of_camera) continue;
    if (has("truth") || has("mocap") || has("pose")) {
      take(files.truth);
    } else if (has("imu") || (has("gyr") && has("acc"))) {
      take(files.imu);
    } else if (has("gyr")) {
      take(files.gyro);
    } else if (has("acc")) {
      take(files.accel);
    } else if (has("frame") || has("image") || has("video") || has("cam") || has("stamp")) {
      take(files.stamps[0]);
    }
  }
  if (cameras.size() > 1 && files.stamps[1].empty()) files.stamps[1] = files.stamps[0];
}

// Of images whose names are stamps.
std::string names_table(const std::string& folder) {
  std::string out;
  for (const std::string& image : images_in(folder)) {
    const fs::path path(image);
    if (!stamp_number(path.stem().string())) continue;
    out += path.stem().string() + "," + path.filename().string() + "\n";
  }
  return out;
}

Table open_camera(const Files& files, size_t c, const StampRule& rule) {
  const std::string& table = files.stamps[c];
  const std::string& camera = cameras_of(files)[c];
  if (!table.empty()) return open_frame_stamps(table, rule);
  const std::string names = files.videos.empty() ? names_table(camera) : "";
  if (names.empty()) {
    throw InputError("no stamps of the frames", camera,
                     "put a table beside it: frames.csv, a stamp for each frame");
  }
  return std::make_unique<TextTable>(TextTable::Content{names}, camera, "names of images", rule);
}

// Stamps of frames in the order of the video; images by their names, or in the order of these.
std::vector<ListedImage> read_camera(const Files& files, size_t c, TextTable& table,
                                     InputLog& log) {
  const std::string& camera = cameras_of(files)[c];
  const Names by_order = images_in(camera);
  std::vector<ListedImage> out;
  for (size_t row = 0; table.next(); ++row) {
    const auto t = table.stamp();
    if (!t) {
      if (!table.cut_off()) table.fail("needs a stamp", "remove or repair the line");
      log.count("image_rows_truncated");
      continue;
    }
    ListedImage image = {*t, ""};
    if (!files.videos.empty()) {
      image.file = VideoImages::key_of(c, row);
    } else {
      const std::string name = table.columns() > 1 ? std::string(table.text(1)) : "";
      const std::string base = fs::path(name).filename().string();
      const bool named = !base.empty() && is_image(base);
      if (!named && row >= by_order.size()) break;
      image.file = named ? camera + "/" + base : by_order[row];
    }
    out.push_back(image);
  }
  if (out.empty()) throw InputError("no stamps of the frames", camera, "check its table");
  put_in_order(out, "image_rows", log);
  return out;
}

void read_imu(const Files& files, TextTable& camera, const StampRule& asked, Recording& out) {
  StampRule rule = asked;
  rule.others = camera.unit();
  const auto settle = [&](const TextTable& imu) {
    if (camera.unit() == StampUnit::kUnknown) {
      camera.settle_unit({kCameraRates, asked.asked, imu.unit()});
    }
  };
  if (!files.imu.empty()) {
    TextTable table(files.imu, "IMU samples", rule);
    settle(table);
    out.imu = read_imu_samples(table, files.imu, out, Rows::kInOrderOfTime);
    if (table.heading().empty()) put_gyro_first(out.imu, out);
    out.note("IMU: " + fs::path(files.imu).filename().string());
    return;
  }
  TextTable gyro(files.gyro, "gyro samples", rule);
  settle(gyro);
  rule.others = gyro.unit();
  TextTable accel(files.accel, "accelerometer samples", rule);
  out.imu = join_sensors(read_triples(gyro, &ImuSample::w_B, files.gyro, out),
                         read_triples(accel, &ImuSample::f_B, files.accel, out));
  if (out.imu.empty()) {
    throw InputError("gyro and accelerometer do not overlap in time", files.accel,
                     "both need stamps of one clock; --stamps says what they count");
  }
  out.note("IMU: " + fs::path(files.gyro).filename().string() + ", with the force of " +
           fs::path(files.accel).filename().string());
}

void check_complete(const Files& files, const std::string& folder) {
  if (!files.imu.empty() || (!files.gyro.empty() && !files.accel.empty())) return;
  std::string tables;
  for (const std::string& table : files.tables) {
    tables += (tables.empty() ? "" : ", ") + fs::path(table).filename().string();
  }
  throw InputError("no table of the IMU; there are " + (tables.empty() ? "none" : tables), folder,
                   "name it imu.csv, or gyro.csv and accel.csv (docs/formats.md)");
}

std::string calibration_in(const std::string& folder, const RecordingOptions& options,
                           InputLog& log) {
  if (!options.calibration.empty()) return options.calibration;
  const std::string own = folder + "/calibration.cfg";
  if (!fs::is_regular_file(own)) {
    throw InputError("no calibration of cameras and IMU together", folder,
                     "give one with --calib (docs/formats.md)");
  }
  log.note("calibration: " + own);
  return own;
}

std::shared_ptr<VideoImages> open_videos(const Files& files,
                                         const std::vector<ListedImage> (&images)[2],
                                         Recording& recording) {
  auto out = std::make_shared<VideoImages>(files.videos);
  for (size_t c = 0; c < std::min<size_t>(2, files.videos.size()); ++c) {
    const size_t frames = out->frames(c), rows = images[c].size();
    if (rows == 0 || frames == 0 || frames == rows) continue;
    recording.note(fs::path(files.videos[c]).filename().string() + " has " +
                   std::to_string(frames) + " frames, its table " + std::to_string(rows) +
                   " rows: taken one by one from the first");
  }
  return out;
}

void read_truth(const std::string& path, StampUnit unit, Recording& recording) {
  if (path.empty()) return;
  recording.truth = read_trajectory(path, {kCameraRates, StampUnit::kUnknown, unit});
  recording.count("truth_rows_truncated", recording.truth.rows_truncated);
  recording.note("truth: " + fs::path(path).filename().string());
}

}  // namespace

bool is_loose(const std::string& path) {
  if (!fs::is_directory(path)) return is_video(path);
  const Files files = list(path);
  return !files.videos.empty() || (!files.images.empty() && !files.tables.empty());
}

void read_loose_files(const std::string& path, const RecordingOptions& options,
                      Recording& recording) {
  const bool is_file = !fs::is_directory(path);
  const std::string beside = fs::path(path).parent_path().string();
  const std::string folder = !is_file ? path : beside.empty() ? "." : beside;
  Files files = list(folder);
  if (is_file) files.videos = {path};
  tell_tables(files);
  check_complete(files, folder);
  recording.kind = files.videos.empty() ? "images and tables" : "video and tables";
  const std::string calibration = calibration_in(folder, options, recording);
  const Names& cameras = cameras_of(files);
  RigOptions how;
  how.imu = options.imu;
  how.cameras = options.cameras;
  how.mono = options.mono || cameras.size() < 2;
  how.image_size = [&] {
    if (files.videos.empty()) return image_size_in({cameras[0]});
    cv::Mat grey;
    VideoImages(files.videos).read(VideoImages::key_of(0, 0), grey);
    return std::pair(grey.cols, grey.rows);
  };
  const Rig rig = read_rig(calibration, how, recording);
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    if (size_t(rig.camera[c]) < std::min<size_t>(2, cameras.size())) continue;
    throw InputError("no video or images of cam" + std::to_string(rig.camera[c]), folder,
                     "name the cameras that are there with --cameras");
  }
  const StampRule asked = {kCameraRates, options.stamps, {}};
  const Table left = open_camera(files, size_t(rig.camera[0]), asked);
  read_imu(files, *left, {kImuRates, options.stamps, {}}, recording);
  take_rig(rig, calibration, recording);
  constexpr TimeNs kWorthAWord = 10'000'000;
  note_gaps(recording.imu, "imu", kWorthAWord, recording);
  std::vector<ListedImage> images[2];
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    const auto number = size_t(rig.camera[c]);
    const Table right =
        c == 0 ? nullptr : open_camera(files, number, {kCameraRates, left->unit(), left->unit()});
    images[number] = read_camera(files, number, c == 0 ? *left : *right, recording);
    recording.note((c == 0 ? "left camera: " : "right camera: ") +
                   fs::path(cameras[number]).filename().string());
  }
  if (!files.videos.empty()) recording.store = open_videos(files, images, recording);
  const bool alone = rig.calibration.cameras < 2;
  add_frames(rig, images[rig.camera[0]], alone ? std::vector<ListedImage>{} : images[rig.camera[1]],
             "the left camera", recording);
  read_truth(files.truth, left->unit(), recording);
}

}  // namespace pirvs::tools
