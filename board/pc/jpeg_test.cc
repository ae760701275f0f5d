// JPEGs as cameras send them, whole and broken.
#include "board/pc/jpeg.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

namespace pirvs::board {
namespace {

constexpr int kWidth = 70, kHeight = 50;

cv::Mat scene() {
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  cv::randu(image, 0, 255);
  cv::GaussianBlur(image, image, cv::Size(9, 9), 3);
  return image;
}

std::vector<uint8_t> jpeg_of(const cv::Mat& image) {
  std::vector<uint8_t> out;
  cv::imencode(".jpg", image, out, {cv::IMWRITE_JPEG_QUALITY, 95});
  return out;
}

bool decode(const std::vector<uint8_t>& jpeg, cv::Mat& out) {
  out.create(kHeight, kWidth, CV_8U);
  return jpeg_to_grey(jpeg.data(), jpeg.size(), kWidth, kHeight, out.data);
}

TEST(jpeg, is_the_luma_of_the_image) {
  const cv::Mat image = scene();
  cv::Mat grey, out;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  ASSERT_TRUE(decode(jpeg_of(image), out));
  EXPECT_LT(cv::norm(out, grey, cv::NORM_INF), 12);
  EXPECT_LT(cv::norm(out, grey, cv::NORM_L1) / (kWidth * kHeight), 2);
}

// A segment is FF, its kind, and its length with these two bytes.
TEST(jpeg, needs_no_huffman_tables) {
  const std::vector<uint8_t> whole = jpeg_of(scene());
  std::vector<uint8_t> bare(whole.begin(), whole.begin() + 2);
  size_t at = 2;
  while (whole[at + 1] != 0xda) {
    const size_t next = at + 2 + size_t(whole[at + 2] * 256 + whole[at + 3]);
    if (whole[at + 1] != 0xc4) bare.insert(bare.end(), &whole[at], &whole[next]);
    at = next;
  }
  bare.insert(bare.end(), whole.begin() + long(at), whole.end());
  ASSERT_LT(bare.size(), whole.size() - 300);
  cv::Mat with, without;
  ASSERT_TRUE(decode(whole, with));
  ASSERT_TRUE(decode(bare, without));
  EXPECT_EQ(cv::norm(with, without, cv::NORM_L1), 0);
}

TEST(jpeg, refuses_what_is_broken_or_of_another_size) {
  const std::vector<uint8_t> whole = jpeg_of(scene());
  cv::Mat out;
  for (const size_t size :
       {size_t(0), size_t(1), size_t(20), whole.size() / 2, whole.size() - 40}) {
    EXPECT_FALSE(decode({whole.begin(), whole.begin() + long(size)}, out)) << size;
  }
  cv::Mat small = scene()(cv::Rect(0, 0, kWidth - 1, kHeight));
  EXPECT_FALSE(decode(jpeg_of(small), out));
}

// Bytes that flip on the wire: refused or shown, and nothing is written beside the image.
TEST(jpeg, survives_any_damage) {
  const std::vector<uint8_t> whole = jpeg_of(scene());
  std::mt19937 random(4);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<uint8_t> hurt = whole;
    for (uint32_t k = 0; k <= random() % 4; ++k) hurt[random() % hurt.size()] = uint8_t(random());
    if (random() % 4 == 0) hurt.resize(random() % hurt.size());
    cv::Mat out;
    refused += !decode(hurt, out);
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace pirvs::board
