#include "board/linux/image_share.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "board/usb/image_client.h"
#include "bsp/api/clock.h"

namespace pirvs::board {
namespace {

constexpr int kWidth = 48, kHeight = 32, kStride = 64;

class ImageShareTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "pirvs_images_" + std::to_string(getpid());
    ASSERT_EQ(share_.open(path_.c_str(), 2, kWidth, kHeight), Status::kOk);
  }
  void TearDown() override { share_.close(); }

  // A frame whose pixels say its number and camera; rows have a gap behind them.
  void shoot(uint8_t number, uint8_t present = 3) {
    StereoFrame frame;
    for (int c = 0; c < 2; ++c) {
      pixels_[c].assign(kStride * kHeight, 0xee);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x)
          pixels_[c][size_t(y * kStride + x)] = grey(number, c, x, y);
      }
      frame.image[c] = {pixels_[c].data(), kWidth, kHeight, kStride};
      frame.info[c].sequence = number;
    }
    frame.t = 1000 * number;
    frame.present = present;
    share_.frame(frame);
  }
  static uint8_t grey(uint8_t number, int camera, int x, int y) {
    return uint8_t(number * 16 + camera * 7 + x + 3 * y);
  }
  // As another process does; the share looks for clients at its frames, kAsk_ns apart.
  void connect(ImageClient& client, int camera) {
    Status status = Status::kNotFound;
    std::thread other([&] { status = client.connect(path_.c_str(), camera); });
    for (int i = 0; i < 30 && share_.counters().clients < clients_ + 1; ++i) {
      usleep(20'000);
      shoot(0);
    }
    other.join();
    ++clients_;
    ASSERT_EQ(status, Status::kOk);
  }
  void expect_image(ImageClient& client, uint8_t number, int camera) {
    ImageReady image;
    ASSERT_EQ(client.next(image), Status::kOk);
    EXPECT_EQ(image.sequence, number);
    EXPECT_EQ(image.t, 1000 * number);
    EXPECT_EQ(image.camera, uint32_t(camera));
    const uint8_t* at = client.pixels(image);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) ASSERT_EQ(*at++, grey(number, camera, x, y));
    }
    client.give_back(image);
  }

  ImageShare share_;
  std::string path_;
  std::vector<uint8_t> pixels_[2];
  uint32_t clients_ = 0;
};

TEST_F(ImageShareTest, GivesTheWantedCamerasImages) {
  ImageClient client;
  connect(client, 1);
  ImageReady image;
  for (uint8_t i = 1; i < 20; ++i) {
    shoot(i);
    expect_image(client, i, 1);
    EXPECT_EQ(client.next(image), Status::kEmpty);
  }
  shoot(20, 1);  // the other camera's alone
  EXPECT_EQ(client.next(image), Status::kEmpty);
  EXPECT_EQ(share_.counters().sent, 19u);
  EXPECT_EQ(share_.counters().lost, 0u);
  client.close();
}

TEST_F(ImageShareTest, CopiesNothingWithoutAClient) {
  for (uint8_t i = 0; i < 10; ++i) shoot(i);
  EXPECT_EQ(share_.counters().sent + share_.counters().lost, 0u);
}

TEST_F(ImageShareTest, ASlowClientLosesImagesThatAreCounted) {
  ImageClient client;
  connect(client, 0);
  ImageReady image;
  for (uint8_t i = 1; i <= 10; ++i) shoot(i);
  EXPECT_EQ(share_.counters().sent, ImageShare::kSlots);
  EXPECT_EQ(share_.counters().lost, 10 - ImageShare::kSlots);
  // What it holds stays as it was.
  for (uint8_t i = 1; i <= ImageShare::kSlots; ++i) expect_image(client, i, 0);
  shoot(11);
  ASSERT_EQ(client.next(image), Status::kOk);
  EXPECT_EQ(image.lost, 10 - ImageShare::kSlots);
  client.close();
}

TEST_F(ImageShareTest, ANewClientMayComeWhenOneHasGone) {
  ImageClient first, second;
  connect(first, 0);
  shoot(1);  // it is gone with all its slots
  first.close();
  connect(second, 0);
  for (uint8_t i = 1; i < 10; ++i) {
    shoot(i);
    expect_image(second, i, 0);
  }
  second.close();
}

TEST_F(ImageShareTest, ASecondClientIsTurnedAway) {
  ImageClient first, second;
  connect(first, 0);
  Status status = Status::kOk;
  std::thread other([&] { status = second.connect(path_.c_str(), 0); });
  for (int i = 0; i < 30 && share_.counters().refused == 0; ++i) {
    usleep(20'000);
    shoot(0);
  }
  other.join();
  EXPECT_EQ(status, Status::kNotFound);
  EXPECT_EQ(share_.counters().refused, 1u);
  first.close();
}

TEST_F(ImageShareTest, LetsGoOfAClientThatTalksNonsense) {
  const ImageRequest nonsense[] = {{0xff, ImageRequest::kNoSlot}, {1, 3}, {1, 77}};
  for (const ImageRequest& request : nonsense) {
    const uint32_t refused = share_.counters().refused;
    ImageClient client;
    connect(client, 0);
    ASSERT_EQ(send(client.fd(), &request, sizeof request, 0), ssize_t(sizeof request));
    shoot(1);
    EXPECT_EQ(share_.counters().refused, refused + 1);
    client.close();
  }
  ImageClient client;
  connect(client, 0);
  ASSERT_EQ(send(client.fd(), "hello", 5, 0), 5);
  shoot(1);
  EXPECT_EQ(share_.counters().refused, 4u);
  client.close();
}

// What pirvsd gives out it alone can change.
TEST_F(ImageShareTest, TheClientCannotWrite) {
  ImageClient client;
  connect(client, 0);
  void* const page = const_cast<uint8_t*>(client.pixels({}));
  EXPECT_NE(mprotect(page, 4096, PROT_READ | PROT_WRITE), 0);
  client.close();
}

TEST_F(ImageShareTest, TakesASocketThatWasLeftAndNothingElse) {
  ImageShare other;
  EXPECT_EQ(other.open(path_.c_str(), 1, kWidth, kHeight), Status::kOk);  // as after a kill
  other.close();
  const std::string file = path_ + "_file";
  fclose(fopen(file.c_str(), "w"));
  EXPECT_EQ(other.open(file.c_str(), 1, kWidth, kHeight), Status::kBusFault);
  EXPECT_EQ(unlink(file.c_str()), 0) << "still there";
}

// For docs/device.md.
TEST_F(ImageShareTest, CostsNothingWithoutAClient) {
  constexpr int kFrames = 1'000'000;
  StereoFrame frame;
  const TimeNs begin = bsp::now();
  for (int i = 0; i < kFrames; ++i) share_.frame(frame);
  const double ns = double(bsp::now() - begin) / kFrames;
  std::printf("without a client: %.1f ns a frame\n", ns);
  EXPECT_LT(ns, 2000);
}

}  // namespace
}  // namespace pirvs::board
