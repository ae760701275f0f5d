// What the tests of all kernels share: images that end where readable memory ends, and content.
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <utility>

#include "core/kernels/image.h"

namespace pirvs::testing {

// size bytes whose last one is the last before an unmapped page, and whose first one comes right
// after an unmapped page if size is a multiple of the page.
class PageEnd {
 public:
  explicit PageEnd(size_t size) : size_(size) {
    const size_t page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    readable_ = (size + page - 1) / page * page;
    mapped_ = readable_ + page;
    void* begin =
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (begin == MAP_FAILED) abort();
    begin_ = static_cast<uint8_t*>(begin);
    if (mprotect(begin_ + readable_, page, PROT_NONE) != 0) abort();
  }
  PageEnd(PageEnd&& other) noexcept { swap(other); }
  PageEnd& operator=(PageEnd&& other) noexcept {
    swap(other);
    return *this;
  }
  ~PageEnd() {
    if (begin_ != nullptr) munmap(begin_, mapped_);
  }
  uint8_t* data() { return begin_ + readable_ - size_; }
  const uint8_t* data() const { return begin_ + readable_ - size_; }
  size_t size() const { return size_; }

 private:
  void swap(PageEnd& other) {
    std::swap(begin_, other.begin_);
    std::swap(size_, other.size_);
    std::swap(readable_, other.readable_);
    std::swap(mapped_, other.mapped_);
  }
  uint8_t* begin_ = nullptr;
  size_t size_ = 0, readable_ = 0, mapped_ = 0;
};

// An image whose last pixel is the last byte before an unmapped page.
class Image {
 public:
  Image(int width, int height, int stride)
      : memory_(static_cast<size_t>(height - 1) * stride + width),
        view_{memory_.data(), width, height, stride} {}
  Image(int width, int height) : Image(width, height, width) {}
  uint8_t* data() { return memory_.data(); }
  uint8_t& at(int x, int y) { return memory_.data()[y * view_.stride + x]; }
  const ImageView& view() const { return view_; }

  // value(x, y) is rounded into 0..255.
  template <class Value>
  Image& fill(Value value) {
    for (int y = 0; y < view_.height; ++y)
      for (int x = 0; x < view_.width; ++x) {
        const double v = std::floor(value(x, y) + 0.5);
        at(x, y) = static_cast<uint8_t>(v < 0 ? 0 : v > 255 ? 255 : v);
      }
    return *this;
  }
  Image& fill_random(uint32_t seed) {
    std::mt19937 random(seed);
    return fill([&](int, int) { return random() % 256; });
  }

 private:
  PageEnd memory_;
  ImageView view_;
};

// A band-limited scene that can be sampled anywhere: 0..255, detail of about 6 px and more.
inline double scene(double x, double y) {
  return 128 + 34 * std::sin(0.31 * x + 0.12 * y) + 31 * std::sin(0.17 * x - 0.41 * y + 1.0) +
         28 * std::sin(0.53 * x + 0.47 * y + 2.0) + 22 * std::sin(0.71 * x - 0.23 * y + 0.5);
}

// Six ways to fill an image: all 0, all 255, checkerboard, random, scene, one bright pixel.
inline constexpr int kContents = 6;
inline void fill(Image& image, int content, uint32_t seed) {
  const int width = image.view().width, height = image.view().height;
  if (content == 0) image.fill([](int, int) { return 0; });
  if (content == 1) image.fill([](int, int) { return 255; });
  if (content == 2) image.fill([](int x, int y) { return (x + y) % 2 * 255; });
  if (content == 3) image.fill_random(seed);
  if (content == 4) image.fill([](int x, int y) { return scene(x, y); });
  if (content == 5)
    image.fill([&](int x, int y) { return x == width / 2 && y == height / 2 ? 255 : 0; });
}

}  // namespace pirvs::testing
