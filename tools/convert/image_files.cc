#include "tools/convert/image_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

namespace pirvs::tools {
namespace {

EncodedImage as_png(const ImageView& image) {
  constexpr int kFast = 1;
  const cv::Mat pixels(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                       size_t(image.stride));
  EncodedImage out;
  out.format = "png";
  cv::imencode(".png", pixels, out.bytes, {cv::IMWRITE_PNG_COMPRESSION, kFast});
  return out;
}

}  // namespace

ImageFiles::ImageFiles(const Recording& recording, bool web_only) : recording_(recording) {
  bool as_they_are = recording.turns[0] == 0 && recording.turns[1] == 0;
  for (const FrameFiles& frame : recording.frames) {
    const std::string& any = frame.image[frame.image[0].empty()];
    as_they_are = as_they_are && !any.empty();
    if (!as_they_are) break;
    const EncodedImage first = load(any);
    if (first.bytes.empty() && !recording.store) continue;  // a file that is missing
    const bool web = first.format == "jpeg" || first.format == "png";
    as_they_are = !first.format.empty() && (web || !web_only);
    break;
  }
  if (!as_they_are) player_ = std::make_unique<Player>(recording);
}

void ImageFiles::next(EncodedImage (&out)[2]) {
  for (EncodedImage& image : out) image = {};
  const FrameFiles& files = recording_.frames.at(frame_++);
  if (player_) {
    const StereoFrame* const frame = player_->next();
    for (int c = 0; c < recording_.calibration.cameras; ++c) {
      if ((frame->present >> c & 1) != 0) out[c] = as_png(frame->image[c]);
    }
    player_->release(frame);
    return;
  }
  for (int c = 0; c < recording_.calibration.cameras; ++c) {
    if (files.image[c].empty()) continue;
    out[c] = load(files.image[c]);
    if (!out[c].bytes.empty() && !out[c].format.empty()) continue;
    out[c] = {};
    ++missing_;
  }
}

std::vector<Count> ImageFiles::rejected() const {
  if (player_) return player_->rejected();
  return {{"images_missing", missing_}};
}

EncodedImage ImageFiles::load(const std::string& name) const {
  if (recording_.store) return recording_.store->encoded(name);
  std::ifstream file(name, std::ios::binary);
  if (!file) return {};
  EncodedImage out;
  out.bytes.assign(std::istreambuf_iterator<char>(file), {});
  out.format = std::filesystem::path(name).extension().string();
  out.format.erase(0, 1);
  std::transform(out.format.begin(), out.format.end(), out.format.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (out.format == "jpg") out.format = "jpeg";
  return out;
}

}  // namespace pirvs::tools
