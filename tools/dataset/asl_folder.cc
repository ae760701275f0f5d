#include "tools/dataset/asl_folder.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tools/dataset/assemble.h"
#include "tools/dataset/gnss_file.h"
#include "tools/dataset/image_size.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/order_file.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/dataset/text_table.h"
#include "tools/dataset/wheel_file.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtensions[] = {"",     ".png", ".jpg", ".jpeg",
                                       ".pgm", ".bmp", ".tif", ".tiff"};

// ---- images ------------------------------------------------------------------------------------
// Where the names of a list are found: in front of them, and behind.
struct Place {
  std::string folder, extension;
  bool base_name = false;  // the list names folders that are not there
};

std::string path_of(const Place& place, const std::string& name) {
  return place.folder + (place.base_name ? fs::path(name).filename().string() : name) +
         place.extension;
}

// Of the first image that is somewhere; else as ASL has it.
Place place_of(const std::string& mav0, const std::string& camera,
               const std::vector<ListedImage>& images) {
  constexpr size_t kTries = 20;
  const std::string parent = fs::path(mav0).parent_path().string();
  for (size_t i = 0; i < std::min(kTries, images.size()); ++i) {
    for (const bool base_name : {false, true}) {
      for (const std::string& folder :
           {camera + "/data/", camera + "/", camera + "/images/", mav0 + "/", parent + "/"}) {
        for (const char* extension : kExtensions) {
          const Place place = {folder, extension, base_name};
          if (fs::is_regular_file(path_of(place, images[i].file))) return place;
        }
      }
    }
  }
  return {camera + "/data/", "", false};
}

// A folder of images whose names are stamps, as a table.
std::string table_of_names(const std::string& camera) {
  for (const std::string& folder : {camera + "/data", camera, camera + "/images"}) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      const bool image = std::find(std::begin(kExtensions) + 1, std::end(kExtensions),
                                   entry.path().extension().string()) != std::end(kExtensions);
      if (image && stamp_number(entry.path().stem().string())) names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    std::string table;
    for (const std::string& name : names)
      table += fs::path(name).stem().string() + "," + name + "\n";
    if (!table.empty()) return table;
  }
  return "";
}

std::unique_ptr<TextTable> image_table(const std::string& camera, const StampRule& rule) {
  constexpr const char* kWhat = "list of images";
  const std::string path = camera + "/data.csv";
  const std::string names = fs::exists(path) ? "" : table_of_names(camera);
  // Without either it says what is missing.
  if (names.empty()) return std::make_unique<TextTable>(path, kWhat, rule);
  return std::make_unique<TextTable>(TextTable::Content{names}, camera, kWhat, rule);
}

// Which tell on each other what their stamps count.
struct Tables {
  std::unique_ptr<TextTable> left, imu;
};

Tables open_tables(const std::string& left, const std::string& imu, StampUnit asked) {
  Tables out;
  out.left = image_table(left, {kCameraRates, asked, {}});
  out.imu = std::make_unique<TextTable>(imu, "IMU samples",
                                        StampRule{kImuRates, asked, out.left->unit()});
  if (out.left->unit() == StampUnit::kUnknown) {
    out.left->settle_unit({kCameraRates, asked, out.imu->unit()});
  }
  return out;
}

std::vector<ListedImage> read_images(const std::string& mav0, int number, TextTable& table,
                                     Recording& recording) {
  const std::string camera = mav0 + "/cam" + std::to_string(number);
  const Rows rows = recording.order.empty() ? Rows::kInOrderOfTime : Rows::kAsRecorded;
  auto images = read_image_list(table, camera + "/data.csv", recording, rows);
  const Place place = place_of(mav0, camera, images);
  for (ListedImage& image : images) image.file = path_of(place, image.file);
  return images;
}

std::vector<ListedImage> read_right_images(const std::string& mav0, int number, StampUnit unit,
                                           Recording& recording) {
  const auto table =
      image_table(mav0 + "/cam" + std::to_string(number), {kCameraRates, unit, unit});
  return read_images(mav0, number, *table, recording);
}

void read_frames(const std::string& mav0, const Rig& rig, TextTable& table, Recording& recording) {
  const auto left = read_images(mav0, rig.camera[0], table, recording);
  std::vector<ListedImage> right;
  if (rig.calibration.cameras == 2) {
    right = read_right_images(mav0, rig.camera[1], table.unit(), recording);
  }
  add_frames(rig, left, right, "cam" + std::to_string(rig.camera[0]), recording);
}

// Each frame's images are the next ones of the cameras that it says are present. What the tables
// do not hold any more, as after a power cut, has not come.
void read_frames_in_order(const std::string& mav0, TextTable& table, Recording& recording) {
  std::vector<ListedImage> images[2];
  images[0] = read_images(mav0, 0, table, recording);
  if (recording.calibration.cameras == 2) {
    images[1] = read_right_images(mav0, 1, StampUnit::kNanoseconds, recording);
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
    recording.gnss = read_gnss(file, gnss_format(file), recording);
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
  recording.wheels = read_wheels(file, sensor.kind, recording);
  recording.wheels_apart = true;
}

// ---- the rest ----------------------------------------------------------------------------------
void read_truth(const std::string& mav0, const RecordingOptions& options, StampUnit unit,
                Recording& recording) {
  const TimeNs first = recording.frames.front().t, last = recording.frames.back().t;
  const auto overlaps = [&](const Trajectory& truth) {
    return !truth.poses.empty() && truth.poses.front().t <= last && truth.poses.back().t >= first;
  };
  for (const char* name :
       {"/state_groundtruth_estimate0/data.csv", "/groundtruth.tum", "/mocap0/data.csv",
        "/gt0/data.csv", "/gt/data.csv", "/groundtruth.csv", "/groundtruth.txt"}) {
    const std::string path = mav0 + name;
    if (!fs::exists(path)) continue;
    StampRule rule = {kCameraRates, options.stamps, unit};
    recording.truth = read_trajectory(path, rule);
    for (const StampUnit other : kStampUnits) {
      if (overlaps(recording.truth) || options.stamps != StampUnit::kUnknown) break;
      rule.asked = other;
      try {
        const Trajectory read = read_trajectory(path, rule);
        if (overlaps(read)) recording.truth = read;
      } catch (const InputError&) {  // in this unit the stamps do not even rise
      }
    }
    recording.count("truth_rows_truncated", recording.truth.rows_truncated);
    return;
  }
}

void note_units(StampUnit camera, StampUnit imu, const Recording& read, Recording& recording) {
  constexpr TimeNs kYear2000 = 946'684'800'000'000'000;
  const bool usual = camera == StampUnit::kNanoseconds && imu == StampUnit::kNanoseconds &&
                     read.frames.front().t > kYear2000;
  if (usual || read.frames.size() < 2 || read.imu.size() < 2) return;
  const auto hz = [](size_t rows, TimeNs span) {
    return double(rows - 1) / to_seconds(std::max<TimeNs>(span, 1));
  };
  char text[160];
  std::snprintf(text, sizeof text,
                "stamps are taken as %s (images, %.1f Hz) and %s (IMU, %.0f Hz)%s", name(camera),
                hz(read.frames.size(), read.frames.back().t - read.frames.front().t), name(imu),
                hz(read.imu.size(), read.imu.back().t - read.imu.front().t),
                read.frames.front().t > kYear2000 ? "" : ", not since 1970");
  recording.note(text);
}

Rig read_folder_rig(const std::string& mav0, const RecordingOptions& options,
                    Recording& recording) {
  RigOptions how;
  how.imu = options.imu;
  how.cameras = options.cameras;
  how.mono = options.mono;
  how.fallback_imu = mav0 + "/imu0/sensor.yaml";
  how.image_size = [&] {
    const int left = options.cameras.empty() ? 0 : options.cameras[0];
    const std::string camera = mav0 + "/cam" + std::to_string(left);
    return image_size_in({camera + "/data", camera, camera + "/images"});
  };
  Rig rig = options.calibration.empty() ? read_asl_rig(mav0, how, recording)
                                        : read_rig(options.calibration, how, recording);
  const bool alone = !fs::is_directory(mav0 + "/cam" + std::to_string(rig.camera[1]));
  if (alone && options.cameras.empty() && rig.calibration.cameras == 2) {
    how.mono = true;  // the left one's number must not depend on the right one
    rig = read_rig(options.calibration, how, recording);
  }
  return rig;
}

}  // namespace

void read_asl_folder(const std::string& folder, const RecordingOptions& options,
                     Recording& recording) {
  const std::string mav0 = fs::is_directory(folder + "/mav0") ? folder + "/mav0" : folder;
  if (!fs::is_directory(mav0 + "/cam0")) {
    throw InputError("not a recording, it has no cam0", mav0, "give an ASL/EuRoC folder");
  }
  const Rig rig = read_folder_rig(mav0, options, recording);
  const bool whole = options.start_s <= 0 && options.duration_s <= 0;
  if (whole && fs::exists(mav0 + "/order.csv")) recording.order = read_order(mav0 + "/order.csv");
  const bool ordered = !recording.order.empty();
  if (ordered && fs::exists(mav0 + "/maps.csv")) recording.maps = read_maps(mav0 + "/maps.csv");
  const std::string imu = mav0 + "/imu0/data.csv";
  const std::string left = mav0 + "/cam" + std::to_string(rig.camera[0]);
  const Tables tables = open_tables(left, imu, ordered ? StampUnit::kNanoseconds : options.stamps);
  recording.imu = read_imu_samples(*tables.imu, imu, recording,
                                   ordered ? Rows::kAsRecorded : Rows::kInOrderOfTime);
  take_rig(rig, options.calibration.empty() ? mav0 : options.calibration, recording);
  if (ordered) {
    read_frames_in_order(mav0, *tables.left, recording);
    if (recording.frames.empty()) throw InputError("no frames", mav0, "check the recording");
  } else {
    constexpr TimeNs kWorthAWord = 10'000'000;
    note_gaps(recording.imu, "imu0", kWorthAWord, recording);
    read_frames(mav0, rig, *tables.left, recording);
    note_units(tables.left->unit(), tables.imu->unit(), recording, recording);
  }
  read_fixes(mav0, options, recording);
  read_wheels(mav0, options, recording);
  read_truth(mav0, options, tables.left->unit(), recording);
}

}  // namespace pirvs::tools
