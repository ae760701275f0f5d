#include "tools/dataset/video_images.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

VideoImages::VideoImages(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    videos_.push_back({path, nullptr, 0});
    open(videos_.back());
  }
}

std::string VideoImages::key_of(size_t camera, size_t frame) {
  return std::to_string(camera) + " " + std::to_string(frame);
}

void VideoImages::open(Video& video) {
  video.capture = std::make_unique<cv::VideoCapture>(video.path, cv::CAP_FFMPEG);
  video.next = 0;
  if (video.capture->isOpened()) return;
  throw InputError("not a video that can be read", video.path,
                   "try it with ffmpeg; a lossless copy: ffmpeg -i IN -c:v ffv1 OUT.mkv");
}

size_t VideoImages::frames(size_t camera) const {
  const double count = videos_[camera].capture->get(cv::CAP_PROP_FRAME_COUNT);
  return count > 0 ? size_t(count) : 0;
}

ImageRead VideoImages::read(const std::string& key, cv::Mat& grey) {
  size_t camera = 0, frame = 0;
  if (std::sscanf(key.c_str(), "%zu %zu", &camera, &frame) != 2 || camera >= videos_.size()) {
    return ImageRead::kMissing;
  }
  Video& video = videos_[camera];
  if (frame < video.next) open(video);
  for (; video.next < frame; ++video.next) {
    if (!video.capture->grab()) return ImageRead::kMissing;
  }
  cv::Mat image;
  if (!video.capture->read(image) || image.empty()) return ImageRead::kMissing;
  ++video.next;
  if (image.channels() == 1) {
    grey = image;
  } else {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  }
  return grey.depth() == CV_8U ? ImageRead::kGood : ImageRead::kUndecodable;
}

}  // namespace pirvs::tools
