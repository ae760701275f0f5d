#include "tools/dataset/player.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr size_t kTailBytes = 64;  // a writer may append a few bytes after the end marker

bool read_file(const std::string& path, std::vector<uint8_t>& out) {
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (!file) return false;
  out.resize(out.capacity());
  size_t size = 0;
  while (true) {
    if (size == out.size()) out.resize(std::max<size_t>(2 * size, size_t{1} << 20));
    const size_t got = std::fread(out.data() + size, 1, out.size() - size, file);
    if (got == 0) break;
    size += got;
  }
  std::fclose(file);
  out.resize(size);
  return true;
}

// "P5 width height 255" and one byte a pixel: the size says it all. Other headers are the
// decoder's.
bool pgm_cut_off(const std::vector<uint8_t>& file) {
  const std::string head(file.begin(),
                         file.begin() + std::ptrdiff_t(std::min<size_t>(64, file.size())));
  size_t width = 0, height = 0;
  int pixels = 0;
  if (std::sscanf(head.c_str(), "P5 %zu %zu 255%n", &width, &height, &pixels) < 2) return false;
  if (pixels == 0 || width > UINT16_MAX || height > UINT16_MAX) return pixels == 0;
  return file.size() < size_t(pixels) + 1 + width * height;
}

// Decoders fill what is missing of a cut-off file with grey and do not tell; its end marker does.
bool cut_off(const std::vector<uint8_t>& file) {
  static constexpr std::array<uint8_t, 2> kJpegBegin = {0xFF, 0xD8};
  static constexpr std::array<uint8_t, 2> kJpegEnd = {0xFF, 0xD9};
  static constexpr std::array<uint8_t, 4> kPngBegin = {0x89, 'P', 'N', 'G'};
  static constexpr std::array<uint8_t, 4> kPngEnd = {'I', 'E', 'N', 'D'};
  const auto begins = [&](const auto& mark) {
    return file.size() > mark.size() && std::equal(mark.begin(), mark.end(), file.begin());
  };
  const auto ends = [&](const auto& mark) {
    const auto tail = file.end() - std::ptrdiff_t(std::min(file.size(), kTailBytes));
    return std::search(tail, file.end(), mark.begin(), mark.end()) != file.end();
  };
  if (begins(kJpegBegin)) return !ends(kJpegEnd);
  if (begins(kPngBegin)) return !ends(kPngEnd);
  return pgm_cut_off(file);
}

[[noreturn]] void fail_about_size(const Camera& expected, const cv::Size& found,
                                  const std::string& first) {
  const auto size = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  const bool exchanged = found.width == expected.height && found.height == expected.width;
  const bool scaled =
      int64_t{found.width} * expected.height == int64_t{found.height} * expected.width;
  throw InputError("the images' size is not the calibration's (" + size(found.width, found.height) +
                       ", not " + size(expected.width, expected.height) + ")",
                   first,
                   exchanged ? "width and height are exchanged: repair the calibration's resolution"
                   : scaled
                       ? "the calibration is of another resolution: scale fx, fy, cx, cy with it"
                       : "give the calibration of this recording with --calib");
}

}  // namespace

Player::Player(const Recording& recording) : recording_(recording), slots_(kSlots) {
  for (Slot& slot : slots_) {
    for (int c = 0; c < recording.calibration.cameras; ++c) {
      const Camera& camera = recording.calibration.camera[c];
      slot.pixels[c].resize(size_t(camera.width) * size_t(camera.height));
    }
  }
  if (recording.pack == nullptr) check_first_images();
  decoder_ = std::thread([this] { decode_all(); });
}

Player::~Player() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  decoder_.join();
}

const StereoFrame* Player::next() {
  std::unique_lock<std::mutex> lock(mutex_);
  if (played_ == recording_.frames.size()) return nullptr;
  changed_.wait(lock, [this] { return !ready_.empty(); });
  const StereoFrame* const frame = &ready_.front()->frame;
  ready_.pop_front();
  ++played_;
  return frame;
}

void Player::release(const StereoFrame* frame) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Slot& slot : slots_) slot.free = slot.free || &slot.frame == frame;
  }
  changed_.notify_all();
}

std::vector<Count> Player::rejected() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto failed = [this](Read why) { return failed_[static_cast<size_t>(why)]; };
  return {{"images_missing", failed(Read::kMissing)},
          {"images_cut_off", failed(Read::kCutOff)},
          {"images_undecodable", failed(Read::kUndecodable)},
          {"images_of_wrong_size", failed(Read::kWrongSize)}};
}

// A recording that has lost a few images plays; one whose images are elsewhere does not.
void Player::check_first_images() {
  constexpr size_t kTries = 10;
  const size_t tries = std::min(kTries, recording_.frames.size());
  const std::string& first = recording_.frames[0].image[recording_.frames[0].image[0].empty()];
  bool wrong_size = false;
  Camera expected;
  for (size_t i = 0; i < tries; ++i) {
    for (int c = 0; c < recording_.calibration.cameras; ++c) {
      const std::string& path = recording_.frames[i].image[c];
      if (path.empty()) continue;
      const Read result = decode_image(path, c, slots_[0].pixels[c]);
      if (result == Read::kGood) return;
      if (result != Read::kWrongSize) continue;
      wrong_size = true;
      expected = recording_.calibration.camera[c];
    }
  }
  if (wrong_size) fail_about_size(expected, wrong_size_, first);
  throw InputError("no image can be read", first, "check that the recording is complete");
}

Player::Slot* Player::wait_for_free_slot() {
  std::unique_lock<std::mutex> lock(mutex_);
  auto free = slots_.end();
  changed_.wait(lock, [&] {
    free = std::find_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.free; });
    return stop_ || free != slots_.end();
  });
  if (stop_) return nullptr;
  free->free = false;
  return &*free;
}

void Player::decode_all() {
  for (size_t i = 0; i < recording_.frames.size(); ++i) {
    Slot* const slot = wait_for_free_slot();
    if (slot == nullptr) return;
    decode_frame(recording_.frames[i], *slot);
    for (ImageInfo& info : slot->frame.info) info.sequence = uint32_t(i);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ready_.push_back(slot);
    }
    changed_.notify_all();
  }
}

void Player::decode_frame(const FrameFiles& files, Slot& slot) {
  slot.frame = StereoFrame{};
  slot.frame.t = files.t;
  slot.frame.lost_before = files.lost_before;
  for (int c = 0; c < 2; ++c) slot.frame.late[c] = files.late[c];
  for (int c = 0; c < recording_.calibration.cameras; ++c) {
    if (files.pixels[c].data != nullptr) {
      slot.frame.image[c] = files.pixels[c];
      slot.frame.present |= uint8_t(1u << c);
    }
    if (files.image[c].empty()) continue;
    const Read result = decode_image(files.image[c], c, slot.pixels[c]);
    if (result == Read::kGood) {
      const Camera& camera = recording_.calibration.camera[c];
      slot.frame.image[c] = {slot.pixels[c].data(), camera.width, camera.height, camera.width};
      slot.frame.present |= uint8_t(1u << c);
    } else {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++failed_[static_cast<size_t>(result)];
    }
  }
}

Player::Read Player::load(const std::string& path, cv::Mat& image) {
  if (recording_.store) return recording_.store->read(path, image);
  if (!read_file(path, file_)) return Read::kMissing;
  if (cut_off(file_) || file_.empty()) return Read::kCutOff;
  const cv::Mat bytes(1, int(file_.size()), CV_8UC1, file_.data());
  // Not over pixels: on a bad file some decoders leave there what was there before.
  image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  return image.empty() ? Read::kUndecodable : Read::kGood;
}

Player::Read Player::decode_image(const std::string& path, int camera,
                                  std::vector<uint8_t>& pixels) {
  const Camera& expected = recording_.calibration.camera[camera];
  const int turns = recording_.turns[camera];
  cv::Mat image;
  try {
    const Read result = load(path, image);
    if (result != Read::kGood) return result;
    if (turns != 0) {
      constexpr cv::RotateFlags kTurns[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                                            cv::ROTATE_90_COUNTERCLOCKWISE};
      cv::rotate(image, image, kTurns[turns - 1]);
    }
  } catch (const cv::Exception&) {
    return Read::kUndecodable;
  }
  if (image.cols != expected.width || image.rows != expected.height) {
    wrong_size_ = image.size();
    return Read::kWrongSize;
  }
  for (int y = 0; y < image.rows; ++y) {
    std::copy_n(image.ptr(y), image.cols, pixels.begin() + std::ptrdiff_t(y) * image.cols);
  }
  return Read::kGood;
}

}  // namespace pirvs::tools
