#include "tools/calib/board_images.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <opencv2/imgcodecs.hpp>

#include "tools/calib/tag_detector.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/sensor_tables.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

struct Found {
  std::vector<ImageCorners> images;
  ImageSize size;
  TagDetector::Dropped dropped;
  size_t unreadable = 0;
  double rate_hz = 0, grey_sum = 0;
  size_t looked_at = 0;
  std::string error;  // what stands before the path
  std::string path;
};

double rate_of(const std::vector<ListedImage>& list) {
  if (list.size() < 2) return 0;
  std::vector<TimeNs> steps;
  for (size_t i = 1; i < list.size(); ++i) steps.push_back(list[i].t - list[i - 1].t);
  const auto middle = steps.begin() + long(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return 1 / std::max(1e-6, to_seconds(*middle));
}

// The same instants for both cameras: by the grid of time, not by counting.
std::vector<ListedImage> thinned(const std::vector<ListedImage>& list, double rate_hz,
                                 double rate_hz_max) {
  if (!(rate_hz > 1.1 * rate_hz_max)) return list;
  const TimeNs step = from_seconds(1 / rate_hz_max), half = from_seconds(0.5 / rate_hz);
  std::vector<ListedImage> out;
  for (size_t i = 0; i < list.size(); ++i) {
    const TimeNs slot = (list[i].t + half) / step;
    if (i == 0 || (list[i - 1].t + half) / step != slot) out.push_back(list[i]);
  }
  return out;
}

Found find_in(const std::vector<ListedImage>& list, const std::string& folder,
              const Target& target) {
  Found out;
  TagDetector detector(target);
  for (const ListedImage& image : list) {
    const cv::Mat grey = cv::imread(folder + "/" + image.file, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) {
      ++out.unreadable;
      continue;
    }
    if (out.size.width == 0) out.size = {grey.cols, grey.rows};
    if (grey.cols != out.size.width || grey.rows != out.size.height) {
      out.error = "images of several sizes";
      out.path = image.file;
      return out;
    }
    out.grey_sum += cv::mean(grey)[0];
    ++out.looked_at;
    out.images.push_back({image.t, detector.find(grey, out.dropped)});
  }
  return out;
}

// Paths of the list as they lie below the camera's folder.
std::vector<ListedImage> list_images(const std::string& camera, InputLog& log) {
  const std::string table = camera + "/data.csv";
  std::vector<ListedImage> out;
  if (fs::exists(table)) {
    out = read_image_list(table, log);
  } else {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(camera + "/data", error)) {
      const std::string stem = entry.path().stem().string();
      if (stem.empty() || stem.find_first_not_of("0123456789") != std::string::npos) continue;
      if (stem.size() > 18 + 1) continue;
      out.push_back({TimeNs(std::stoll(stem)), entry.path().filename().string()});
    }
    put_in_order(out, "images", log);
  }
  for (ListedImage& image : out) image.file = "data/" + image.file;
  return out;
}

}  // namespace

std::string mav0_of(const std::string& folder) {
  return fs::is_directory(folder + "/mav0") ? folder + "/mav0" : folder;
}

BoardImages find_boards(const std::string& folder, const Target& target, double rate_hz_max,
                        double duration_s_max, InputLog& log) {
  const std::string mav0 = mav0_of(folder);
  BoardImages out;
  out.cameras = fs::is_directory(mav0 + "/cam1") ? 2 : 1;
  std::future<Found> jobs[2];
  for (int c = 0; c < out.cameras; ++c) {
    const std::string camera = mav0 + "/cam" + std::to_string(c);
    std::vector<ListedImage> list = list_images(camera, log);
    if (list.empty()) throw InputError("no images", camera, "give an ASL folder");
    const TimeNs end = list.front().t + from_seconds(duration_s_max);
    out.left_out_s = std::max(out.left_out_s, to_seconds(list.back().t - end));
    list.erase(std::find_if(list.begin(), list.end(),
                            [end](const ListedImage& image) { return image.t > end; }),
               list.end());
    out.rate_hz[c] = rate_of(list);
    jobs[c] = std::async(std::launch::async, [=, rate = out.rate_hz[c]] {
      return find_in(thinned(list, rate, rate_hz_max), camera, target);
    });
  }
  size_t tags = 0, looked_at = 0;
  for (int c = 0; c < out.cameras; ++c) {
    Found found = jobs[c].get();
    const std::string name = mav0 + "/cam" + std::to_string(c);
    if (!found.error.empty()) {
      throw InputError(found.error, name + "/" + found.path, "record at one resolution");
    }
    if (found.looked_at == 0) throw InputError("no image can be read", name, "check data/");
    if (c == 1 && (found.size.width != out.size.width || found.size.height != out.size.height)) {
      throw InputError("the cameras' images differ in size", name, "record both alike");
    }
    out.size = found.size;
    out.mean_grey += found.grey_sum;
    looked_at += found.looked_at;
    for (const ImageCorners& image : found.images) tags += image.corners.size() / 4;
    out.images[c] = std::move(found.images);
    log.count("images_unreadable", found.unreadable);
    log.count("tags_not_of_the_board", found.dropped.unknown);
    log.count("tags_seen_twice", found.dropped.doubled);
    log.count("tags_at_the_rim", found.dropped.at_rim);
    log.count("tags_without_clear_corners", found.dropped.unsettled);
  }
  out.mean_grey /= double(looked_at);
  if (tags > 0) return out;
  throw InputError("no tag of the board is seen", mav0,
                   out.mean_grey < 20 ? "the images are dark: give more light"
                                      : "was the board in view, and is it an AprilGrid of 36h11?");
}

void write_corners(const std::vector<ImageCorners>& images, const std::string& path) {
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  std::FILE* const file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw InputError("cannot write", path, "check space and permissions");
  std::fprintf(file, "#timestamp [ns],tag_id,corner,x [px],y [px]\n");
  for (const ImageCorners& image : images) {
    for (const Corner& corner : image.corners) {
      std::fprintf(file, "%lld,%d,%d,%.4f,%.4f\n", static_cast<long long>(image.t), corner.id / 4,
                   corner.id % 4, corner.uv.x(), corner.uv.y());
    }
  }
  const bool good = std::ferror(file) == 0;
  if (std::fclose(file) != 0 || !good) {
    throw InputError("cannot write", path, "check space and permissions");
  }
}

}  // namespace pirvs::tools
