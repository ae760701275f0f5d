#include "bsp/linux/pixel_format.h"

#include <linux/videodev2.h>

#include <iterator>

#include "core/kernels/grey/grey.h"

namespace pirvs::bsp {
namespace {

using How = PixelFormat::How;

// Newer than Debian 12's header.
constexpr uint32_t kY12P = v4l2_fourcc('Y', '1', '2', 'P');

constexpr PixelFormat kFormats[] = {
    {V4L2_PIX_FMT_GREY, How::kPlane, 1},
    // The luma is a plane of its own, and the first.
    {V4L2_PIX_FMT_NV12, How::kPlane, 1},
    {V4L2_PIX_FMT_NV21, How::kPlane, 1},
    {V4L2_PIX_FMT_NV16, How::kPlane, 1},
    {V4L2_PIX_FMT_NV61, How::kPlane, 1},
    {V4L2_PIX_FMT_YUV420, How::kPlane, 1},
    {V4L2_PIX_FMT_YVU420, How::kPlane, 1},
    {V4L2_PIX_FMT_YUV422P, How::kPlane, 1},
    // In memory of its own, by the multi-planar interface.
    {V4L2_PIX_FMT_NV12M, How::kPlane, 1},
    {V4L2_PIX_FMT_NV21M, How::kPlane, 1},
    {V4L2_PIX_FMT_NV16M, How::kPlane, 1},
    {V4L2_PIX_FMT_NV61M, How::kPlane, 1},
    {V4L2_PIX_FMT_YUYV, How::kPairs, 2},
    {V4L2_PIX_FMT_YVYU, How::kPairs, 2},
    {V4L2_PIX_FMT_UYVY, How::kPairs, 2, 1},
    {V4L2_PIX_FMT_VYUY, How::kPairs, 2, 1},
    {V4L2_PIX_FMT_Y10, How::kWords, 2, 0, 2},
    {V4L2_PIX_FMT_Y12, How::kWords, 2, 0, 4},
    {V4L2_PIX_FMT_Y16, How::kWords, 2, 0, 8},
    {V4L2_PIX_FMT_Y10P, How::kPacked, 5},
    {kY12P, How::kPacked, 3},
    {V4L2_PIX_FMT_SRGGB8, How::kBayer, 1},
    {V4L2_PIX_FMT_SGRBG8, How::kBayer, 1},
    {V4L2_PIX_FMT_SGBRG8, How::kBayer, 1},
    {V4L2_PIX_FMT_SBGGR8, How::kBayer, 1},
    {V4L2_PIX_FMT_SRGGB10, How::kBayerWords, 2, 0, 2},
    {V4L2_PIX_FMT_SGRBG10, How::kBayerWords, 2, 0, 2},
    {V4L2_PIX_FMT_SGBRG10, How::kBayerWords, 2, 0, 2},
    {V4L2_PIX_FMT_SBGGR10, How::kBayerWords, 2, 0, 2},
    {V4L2_PIX_FMT_SRGGB12, How::kBayerWords, 2, 0, 4},
    {V4L2_PIX_FMT_SGRBG12, How::kBayerWords, 2, 0, 4},
    {V4L2_PIX_FMT_SGBRG12, How::kBayerWords, 2, 0, 4},
    {V4L2_PIX_FMT_SBGGR12, How::kBayerWords, 2, 0, 4},
    {V4L2_PIX_FMT_SRGGB16, How::kBayerWords, 2, 0, 8},
    {V4L2_PIX_FMT_SGRBG16, How::kBayerWords, 2, 0, 8},
    {V4L2_PIX_FMT_SGBRG16, How::kBayerWords, 2, 0, 8},
    {V4L2_PIX_FMT_SBGGR16, How::kBayerWords, 2, 0, 8},
    {V4L2_PIX_FMT_SRGGB10P, How::kBayerPacked, 5},
    {V4L2_PIX_FMT_SGRBG10P, How::kBayerPacked, 5},
    {V4L2_PIX_FMT_SGBRG10P, How::kBayerPacked, 5},
    {V4L2_PIX_FMT_SBGGR10P, How::kBayerPacked, 5},
    {V4L2_PIX_FMT_SRGGB12P, How::kBayerPacked, 3},
    {V4L2_PIX_FMT_SGRBG12P, How::kBayerPacked, 3},
    {V4L2_PIX_FMT_SGBRG12P, How::kBayerPacked, 3},
    {V4L2_PIX_FMT_SBGGR12P, How::kBayerPacked, 3},
    {V4L2_PIX_FMT_RGB24, How::kRgb, 3},
    {V4L2_PIX_FMT_BGR24, How::kBgr, 3},
    {V4L2_PIX_FMT_MJPEG, How::kJpeg, 0},
    {V4L2_PIX_FMT_JPEG, How::kJpeg, 0},
};

}  // namespace

PixelFormats pixel_formats() { return {std::begin(kFormats), std::end(kFormats)}; }

bool make_grey(const PixelFormat& format, const RawBuffer& in, JpegToGrey jpeg, uint8_t* out) {
  const RawImage raw = {in.data + format.first, in.stride, in.width, in.height};
  const RawImage made = {out, in.width, in.width, in.height};
  switch (format.how) {
    case How::kPlane:
      if (in.limited) grey_from_limited(raw, out, in.width);
      return true;
    case How::kPairs:
      grey_from_pairs(raw, out, in.width);
      break;
    case How::kWords:
      grey_from_words(raw, format.shift, out, in.width);
      break;
    case How::kPacked:
      grey_from_packed(raw, format.bytes, out, in.width);
      break;
    case How::kBayerPacked:
      grey_from_packed(raw, format.bytes, out, in.width);
      grey_from_bayer(made, out, in.width);
      break;
    case How::kBayer:
      grey_from_bayer(raw, out, in.width);
      break;
    case How::kBayerWords:
      grey_from_words(raw, format.shift, out, in.width);
      grey_from_bayer(made, out, in.width);
      break;
    case How::kRgb:
    case How::kBgr:
      grey_from_rgb(raw, format.how == How::kBgr, out, in.width);
      break;
    case How::kJpeg:
      if (jpeg == nullptr || !jpeg(in.data, in.size, in.width, in.height, out)) return false;
      break;
  }
  if (in.limited) grey_from_limited(made, out, in.width);
  return true;
}

}  // namespace pirvs::bsp
