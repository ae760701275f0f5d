// The pixel formats of V4L2 that can be made 8-bit grey, and how.
// In      pixel_formats(): in the order in which they should be asked for, the cheapest first. A
//         raw image as its format lays it out; limited: its 16 is black and its 235 white.
// Out     make_grey(): 8-bit grey, width bytes a row. is_grey: it lies there as it is, in the first
//         plane, unless it is limited.
// Errors  make_grey: false: a broken JPEG, or one of another size. Nothing else can fail.
// Cost    core/kernels/grey; two of them for a mosaic of more than 8 bits, or a limited range.
//         JPEG: what its decoder takes.
// Source  V4L2 API, "Image Formats".
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

// Decodes the luma of a JPEG of this very size into rows of `width` bytes; a board may have one.
using JpegToGrey = bool (*)(const uint8_t* data, size_t size, int width, int height, uint8_t* out);

struct PixelFormat {
  enum class How : uint8_t {
    kPlane,
    kPairs,
    kWords,
    kPacked,
    kBayer,
    kBayerWords,
    kBayerPacked,
    kRgb,
    kBgr,
    kJpeg
  };
  uint32_t code;
  How how;
  int bytes;      // of a pixel in its row; of packed ones: of a group of pixels
  int first = 0;  // of the bytes that say its grey
  int shift = 0;  // bits of a word beyond 8

  bool is_grey() const { return how == How::kPlane; }
  bool is_jpeg() const { return how == How::kJpeg; }
  bool is_packed() const { return how == How::kPacked || how == How::kBayerPacked; }
  // The least that a row takes.
  int row_bytes(int width) const {
    return is_packed() ? (width + bytes - 2) / (bytes - 1) * bytes : width * bytes;
  }
};

struct RawBuffer {
  const uint8_t* data = nullptr;
  size_t size = 0;  // bytes that are there: of a JPEG
  int stride = 0;
  int width = 0, height = 0;
  bool limited = false;
};

struct PixelFormats {
  const PixelFormat* first;
  const PixelFormat* last;
  const PixelFormat* begin() const { return first; }
  const PixelFormat* end() const { return last; }
};
PixelFormats pixel_formats();

[[nodiscard]] bool make_grey(const PixelFormat& format, const RawBuffer& in, JpegToGrey jpeg,
                             uint8_t* out);

}  // namespace pirvs::bsp
