#include "tools/dataset/logs/log_recording.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "tools/dataset/assemble.h"
#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/image_store.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/log_rig.h"
#include "tools/dataset/logs/ros_message.h"

namespace pirvs::tools {
namespace {

constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCompressed = "sensor_msgs/CompressedImage";
constexpr const char* kImu = "sensor_msgs/Imu";
constexpr const char* kInfo = "sensor_msgs/CameraInfo";
constexpr const char* kTransforms[] = {"tf2_msgs/TFMessage", "tf/tfMessage"};

// A message by "topic chunk at size".
std::string key_of(size_t topic, const LogPlace& place) {
  return std::to_string(topic) + " " + std::to_string(place.chunk) + " " +
         std::to_string(place.at) + " " + std::to_string(place.size);
}

bool read_key(const std::string& key, size_t& topic, LogPlace& place) {
  uint64_t numbers[4] = {};
  const char* at = key.data();
  const char* const end = at + key.size();
  for (uint64_t& number : numbers) {
    while (at < end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc()) return false;
    at = next;
  }
  topic = size_t(numbers[0]);
  place = {numbers[1], numbers[2], numbers[3]};
  return true;
}

class LogImages : public ImageStore {
 public:
  explicit LogImages(std::unique_ptr<LogFile> log) : log_(std::move(log)) {}
  ImageRead read(const std::string& key, cv::Mat& grey) override {
    LogTopic of;
    const Bytes bytes = message(key, of);
    if (bytes.size == 0) return ImageRead::kMissing;
    const bool good = of.type == kImage ? decode_image(bytes, of.cdr, grey)
                                        : decode_compressed_image(bytes, of.cdr, grey);
    return good ? ImageRead::kGood : ImageRead::kUndecodable;
  }
  EncodedImage encoded(const std::string& key) override {
    constexpr uint8_t kPngBegin = 0x89, kJpegBegin = 0xFF;
    LogTopic of;
    const Bytes bytes = message(key, of);
    if (bytes.size == 0 || of.type != kCompressed) return {};
    const Bytes file = compressed_image(bytes, of.cdr);
    if (file.size == 0) return {};
    const uint8_t first = file.data[0];
    return {{file.data, file.data + file.size},
            first == kPngBegin    ? "png"
            : first == kJpegBegin ? "jpeg"
                                  : ""};
  }

 private:
  std::unique_ptr<LogFile> log_;

  Bytes message(const std::string& key, LogTopic& of) {
    size_t topic = 0;
    LogPlace place;
    if (!read_key(key, topic, place) || topic >= log_->topics().size()) return {};
    of = log_->topics()[topic];
    return log_->load(place);
  }
};

struct Found {
  LogTopic topic;
  std::string frame_id;  // of its first message
  size_t messages = 0, bad = 0;
  std::vector<ListedImage> images;
  std::vector<ImuSample> samples;
  std::vector<TrajectoryPose> poses;
  std::optional<CameraInfo> info;  // the first one
  std::vector<RosTransform> transforms;
};

// The transforms of a message, each pair of frames once: the others say the same of a rig, or move.
bool add_transforms(const LogMessage& message, Found& found) {
  std::vector<RosTransform> links;
  if (!decode_transforms(message.bytes, found.topic.cdr, links)) return false;
  for (const RosTransform& link : links) {
    const auto same = [&](const RosTransform& t) { return t.child == link.child; };
    auto& all = found.transforms;
    if (std::none_of(all.begin(), all.end(), same)) all.push_back(link);
  }
  return true;
}

// All that is small; images by their places.
std::vector<Found> scan(LogFile& log) {
  std::vector<Found> out;
  log.scan([&](const LogMessage& message) {
    while (out.size() <= message.topic) {
      out.emplace_back();
      out.back().topic = log.topics()[out.size() - 1];
    }
    Found& found = out[message.topic];
    ++found.messages;
    const LogTopic& topic = found.topic;
    RosHeader header;
    ImuSample sample;
    TrajectoryPose pose;
    bool good = true;
    if (topic.type == kImage || topic.type == kCompressed) {
      good = decode_header(message.bytes, topic.cdr, header);
      if (good) found.images.push_back({header.t, key_of(message.topic, message.place)});
      if (found.images.size() == 1) found.frame_id = header.frame_id;
    } else if (topic.type == kImu) {
      good = decode_imu(message.bytes, topic.cdr, sample) && sample.w_B.allFinite() &&
             sample.f_B.allFinite();
      if (good) found.samples.push_back(sample);
      if (found.frame_id.empty() && decode_header(message.bytes, topic.cdr, header)) {
        found.frame_id = header.frame_id;
      }
    } else if (topic.type == kInfo) {
      if (found.info) return;
      CameraInfo info;
      good = decode_camera_info(message.bytes, topic.cdr, info);
      if (good) found.info = info;
    } else if (topic.type == kTransforms[0] || topic.type == kTransforms[1]) {
      good = add_transforms(message, found);
    } else if (is_pose(topic.type)) {
      good = decode_pose(topic.type, message.bytes, topic.cdr, pose);
      if (good) found.poses.push_back(pose);
    }
    found.bad += !good;
  });
  return out;
}

std::string list_of(const std::vector<Found>& all) {
  std::string out;
  for (const Found& found : all) {
    out += (out.empty() ? "" : ", ") + found.topic.name + " (" + found.topic.type + ", " +
           std::to_string(found.messages) + ")";
  }
  return out.empty() ? "none" : out;
}

bool asked(const RecordingOptions& options, const Found& found) {
  return std::find(options.topics.begin(), options.topics.end(), found.topic.name) !=
         options.topics.end();
}

// Topics of one kind: those asked for in their order, else all in the order of their names.
template <class Has>
std::vector<Found*> of_kind(std::vector<Found>& all, const RecordingOptions& options, Has&& has) {
  std::vector<Found*> named, rest;
  for (const std::string& topic : options.topics) {
    for (Found& found : all) {
      if (found.topic.name == topic && has(found)) named.push_back(&found);
    }
  }
  if (!named.empty()) return named;
  for (Found& found : all) {
    if (has(found)) rest.push_back(&found);
  }
  std::sort(rest.begin(), rest.end(),
            [](const Found* a, const Found* b) { return a->topic.name < b->topic.name; });
  return rest;
}

// The two cameras of a log that has more: the first, and the next of about its rate. Depth and
// colour are passed over where there are others.
std::vector<Found*> cameras_of(std::vector<Found>& all, const std::vector<std::string>& by_rig,
                               const RecordingOptions& options) {
  std::vector<Found*> out;
  const auto has_images = [](const Found& found) { return !found.images.empty(); };
  for (const std::string& topic : by_rig) {
    for (Found& found : all) {
      const std::string& name = found.topic.name;
      const bool same = name == topic || name == topic + "/compressed";
      if (options.topics.empty() && !topic.empty() && same && has_images(found) &&
          (out.empty() || out.back() != &found)) {
        out.push_back(&found);
        break;
      }
    }
  }
  if (out.size() == by_rig.size() && !out.empty()) return out;
  out = of_kind(all, options, has_images);
  if (!options.topics.empty() && !out.empty() && asked(options, *out[0])) return out;
  const auto other = [](const Found* found) {
    const std::string& name = found->topic.name;
    return name.find("depth") != std::string::npos || name.find("color") != std::string::npos ||
           name.find("rgb") != std::string::npos;
  };
  std::vector<Found*> grey;
  std::copy_if(out.begin(), out.end(), std::back_inserter(grey),
               [&](const Found* found) { return !other(found); });
  if (!grey.empty()) out = grey;
  const auto like_first = [&](const Found* found) {
    const size_t a = found->images.size(), b = out[0]->images.size();
    return 3 * a >= b && 3 * b >= a;
  };
  std::vector<Found*> alike;
  std::copy_if(out.begin(), out.end(), std::back_inserter(alike), like_first);
  return alike;
}

bool is_still(const std::vector<ImuSample>& samples, Vec3 ImuSample::*vector) {
  return std::all_of(samples.begin(), samples.end(),
                     [&](const ImuSample& s) { return (s.*vector).isZero(0); });
}

// Also its frame.
std::string read_imu(std::vector<Found>& all, const RecordingOptions& options,
                     const std::string& path, Recording& recording) {
  auto topics = of_kind(all, options, [](const Found& found) { return !found.samples.empty(); });
  Found *whole = nullptr, *gyro = nullptr, *accel = nullptr;
  for (Found* found : topics) {
    put_in_order(found->samples, "imu_rows", recording);
    const bool no_w = is_still(found->samples, &ImuSample::w_B);
    const bool no_f = is_still(found->samples, &ImuSample::f_B);
    Found*& kind = no_w ? accel : no_f ? gyro : whole;
    if (kind == nullptr || kind->samples.size() < found->samples.size()) kind = found;
  }
  if (whole != nullptr) {
    recording.imu = whole->samples;
    recording.note("IMU: " + whole->topic.name);
  } else if (gyro != nullptr && accel != nullptr && accel->samples.size() > 1) {
    recording.imu = join_sensors(gyro->samples, accel->samples);
    recording.note("IMU: " + gyro->topic.name + ", with the force of " + accel->topic.name);
  }
  if (recording.imu.empty()) {
    throw InputError(
        "no IMU: no messages of " + std::string(kImu) + "; the log has " + list_of(all), path,
        "record the IMU's topic, too");
  }
  return (whole != nullptr ? whole : gyro)->frame_id;
}

void read_truth(std::vector<Found>& all, const RecordingOptions& options, Recording& recording) {
  const auto topics =
      of_kind(all, options, [](const Found& found) { return !found.poses.empty(); });
  if (topics.empty()) return;
  // The one of the highest rate: it is a motion capture's, and odometry is slower.
  Found* best = topics[0];
  for (Found* found : topics) {
    if (found->poses.size() > best->poses.size()) best = found;
  }
  auto& poses = best->poses;
  std::stable_sort(poses.begin(), poses.end(),
                   [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t < b.t; });
  poses.erase(
      std::unique(poses.begin(), poses.end(),
                  [](const TrajectoryPose& a, const TrajectoryPose& b) { return a.t == b.t; }),
      poses.end());
  recording.truth.poses = poses;
  recording.note("truth: " + best->topic.name);
}

void read_frames(const std::vector<Found*>& cameras, const Rig& rig, Recording& recording) {
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    Found& found = *cameras[size_t(rig.camera[c])];
    put_in_order(found.images, "image_rows", recording);
    recording.note((c == 0 ? "left camera: " : "right camera: ") + found.topic.name);
  }
  const Found& left = *cameras[size_t(rig.camera[0])];
  const bool alone = rig.calibration.cameras < 2;
  add_frames(rig, left.images,
             alone ? std::vector<ListedImage>{} : cameras[size_t(rig.camera[1])]->images,
             left.topic.name, recording);
}

// The one asked for, or what `pirvs convert` has left beside the log; empty: none.
std::string calibration_of(const std::string& path, const RecordingOptions& options,
                           InputLog& log) {
  if (!options.calibration.empty()) return options.calibration;
  const std::string beside = std::filesystem::path(path).replace_extension(".cfg").string();
  if (!std::filesystem::is_regular_file(beside)) return "";
  log.note("calibration: " + beside);
  return beside;
}

// What the log says itself.
RigFile own_rig(const std::vector<Found>& all, const std::vector<Found*>& cameras,
                const std::string& imu_frame, const RecordingOptions& options,
                const std::string& path) {
  std::vector<RosTransform> transforms;
  for (const Found& found : all) {
    transforms.insert(transforms.end(), found.transforms.begin(), found.transforms.end());
  }
  std::vector<LogCamera> out;
  const size_t wanted = options.mono ? 1 : 2;
  for (size_t c = 0; c < std::min(wanted, cameras.size()); ++c) {
    const std::string& topic = cameras[c]->topic.name;
    const auto info = std::find_if(all.begin(), all.end(), [&](const Found& found) {
      return found.info && found.topic.name == info_topic_of(topic);
    });
    if (info == all.end()) {
      throw InputError(
          "a log has no calibration of cameras and IMU together, and this one has no " +
              info_topic_of(topic) + " either",
          path, "give one with --calib (docs/formats.md)");
    }
    out.push_back({topic, cameras[c]->frame_id, info->topic.name, *info->info});
  }
  return rig_of_log(path, out, imu_frame, transforms);
}

std::pair<int, int> size_of(LogFile& log, const Found& camera) {
  size_t topic = 0;
  LogPlace place;
  cv::Mat grey;
  if (!read_key(camera.images[0].file, topic, place)) return {0, 0};
  const Bytes bytes = log.load(place);
  const bool good = camera.topic.type == kImage
                        ? decode_image(bytes, camera.topic.cdr, grey)
                        : decode_compressed_image(bytes, camera.topic.cdr, grey);
  return good ? std::pair(grey.cols, grey.rows) : std::pair(0, 0);
}

}  // namespace

void read_log(std::unique_ptr<LogFile> log, const std::string& path,
              const RecordingOptions& options, Recording& recording) {
  const std::string calibration = calibration_of(path, options, recording);
  recording.kind = log->kind();
  auto all = scan(*log);
  if (log->cut_off()) recording.note("the log is cut off: read up to there");
  RigOptions how;
  how.imu = options.imu;
  how.cameras = options.cameras;
  how.mono = options.mono;
  const bool given = !calibration.empty();
  const auto cameras =
      cameras_of(all, given ? rig_topics(calibration) : std::vector<std::string>(), options);
  if (cameras.empty()) {
    throw InputError("no images: no messages of " + std::string(kImage) + " or " + kCompressed +
                         "; the log has " + list_of(all),
                     path, "record the cameras' topics, too");
  }
  if (cameras.size() < 2) how.mono = true;
  how.image_size = [&] { return size_of(*log, *cameras[0]); };
  const std::string imu_frame = read_imu(all, options, path, recording);
  const Rig rig =
      given ? read_rig(calibration, how, recording)
            : make_rig(own_rig(all, cameras, imu_frame, options, path), path, how, recording);
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    if (size_t(rig.camera[c]) < cameras.size()) continue;
    throw InputError(
        "no topic for cam" + std::to_string(rig.camera[c]) + "; the log has " + list_of(all), path,
        "name the cameras' topics with --topics, in the calibration's order");
  }
  take_rig(rig, given ? calibration : path, recording);
  constexpr TimeNs kWorthAWord = 10'000'000;
  note_gaps(recording.imu, "imu", kWorthAWord, recording);
  read_frames(cameras, rig, recording);
  read_truth(all, options, recording);
  for (const Found& found : all) recording.count("log_messages_bad", found.bad);
  recording.store = std::make_shared<LogImages>(std::move(log));
}

}  // namespace pirvs::tools
