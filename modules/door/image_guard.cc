#include "modules/door/image_guard.h"

#include <cstring>

namespace pirvs {
namespace {

constexpr int kEveryRow = 16;

// 0 for a flat image: words of one value, with all eight pixels alike.
uint64_t checksum(const ImageView& image) {
  uint64_t sum = 0xcbf29ce484222325u, first = 0;
  std::memcpy(&first, image.data, sizeof first);
  bool flat = first == (first & 0xff) * 0x0101010101010101u;
  for (int y = 0; y < image.height; y += kEveryRow) {
    const uint8_t* const row = image.row(y);
    for (int x = 0; x + 8 <= image.width; x += 8) {
      uint64_t word;
      std::memcpy(&word, row + x, sizeof word);
      flat = flat && word == first;
      sum = (sum ^ word) * 0x100000001b3u;
    }
  }
  return flat ? 0 : sum | 1;
}

}  // namespace

void ImageGuard::configure(const Camera* cameras, int count, const DoorParams& params) {
  *this = ImageGuard{};
  count_ = count;
  for (int c = 0; c < count; ++c) {
    width_[c] = cameras[c].width;
    height_[c] = cameras[c].height;
  }
  pair_ = from_seconds(static_cast<double>(params.pair_s));
}

void ImageGuard::check(StereoFrame& frame, DoorLosses& losses) {
  bool missing = false;
  for (int c = 0; c < count_; ++c) {
    if ((frame.present >> c & 1) == 0) {
      missing = true;
    } else if (!is_good(frame, c, losses)) {
      frame.present = static_cast<uint8_t>(frame.present & ~(1u << c));
      frame.image[c] = ImageView{};
    }
  }
  if (missing) losses.add(DoorLoss::kCameraMissing);
}

bool ImageGuard::is_good(const StereoFrame& frame, int c, DoorLosses& losses) {
  const ImageView& image = frame.image[c];
  if (image.data == nullptr || image.width != width_[c] || image.height != height_[c]) {
    losses.add(DoorLoss::kCameraWrongSize);
    return false;
  }
  if (frame.late[c] > pair_ || frame.late[c] < -pair_) {
    losses.add(DoorLoss::kCameraLate);
    return false;
  }
  const uint64_t sum = checksum(image);
  const bool frozen = sum != 0 && sum == sum_[c];
  sum_[c] = sum;
  if (frozen) losses.add(DoorLoss::kCameraFrozen);
  return !frozen;
}

}  // namespace pirvs
