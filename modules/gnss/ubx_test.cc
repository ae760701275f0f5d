#include "modules/gnss/ubx.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace pirvs {
namespace {

using Bytes = std::vector<uint8_t>;

template <class T>
void put(Bytes& to, size_t at, T value) {
  std::memcpy(to.data() + at, &value, sizeof value);
}

Bytes frame(uint8_t group, uint8_t id, const Bytes& payload) {
  Bytes out = {0xb5, 0x62, group, id, uint8_t(payload.size() & 255), uint8_t(payload.size() >> 8)};
  out.insert(out.end(), payload.begin(), payload.end());
  uint8_t a = 0, b = 0;
  for (size_t i = 2; i < out.size(); ++i) a = uint8_t(a + out[i]), b = uint8_t(b + a);
  out.push_back(a), out.push_back(b);
  return out;
}

// 2025-08-28 17:30:21.749542955 UTC, RTK fixed.
Bytes pvt(uint32_t tow_ms = 408639750, uint8_t flags = 131) {
  Bytes p(92, 0);
  put(p, 0, tow_ms);
  put(p, 4, uint16_t(2025));
  p[6] = 8, p[7] = 28, p[8] = 17, p[9] = 30, p[10] = 21, p[11] = 55;
  put(p, 16, int32_t(749542955));
  p[20] = 3, p[21] = flags;
  put(p, 24, int32_t(-1051471665));
  put(p, 28, int32_t(400966916));
  put(p, 32, int32_t(1580048));
  put(p, 40, uint32_t(14));
  put(p, 44, uint32_t(10));
  put(p, 48, int32_t(690));
  put(p, 52, int32_t(-703));
  put(p, 56, int32_t(-72));
  put(p, 68, uint32_t(70));
  return frame(1, 7, p);
}

Bytes cov(uint32_t tow_ms) {
  Bytes p(64, 0);
  put(p, 0, tow_ms);
  p[5] = p[6] = 1;
  put(p, 16, 0.04f), put(p, 28, 0.16f), put(p, 36, 0.25f);
  put(p, 40, 0.01f), put(p, 52, 0.01f), put(p, 60, 0.01f);
  return frame(1, 0x36, p);
}

std::vector<ReceiverFix> read(UbxReader& reader, const Bytes& bytes) {
  std::vector<ReceiverFix> out;
  ReceiverFix fix;
  for (const uint8_t byte : bytes) {
    if (reader.take(byte, fix)) out.push_back(fix);
  }
  return out;
}

void expect_the_fix(const ReceiverFix& read) {
  EXPECT_EQ(read.fix.type, GnssFixType::kFixed);
  EXPECT_NEAR(read.fix.latitude_deg, 40.0966916, 1e-12);
  EXPECT_NEAR(read.fix.longitude_deg, -105.1471665, 1e-12);
  EXPECT_NEAR(read.fix.height_m, 1580.048, 1e-9);
  EXPECT_LT((read.fix.v_ned - Vec3(0.690, -0.703, -0.072)).norm(), 1e-12);
  EXPECT_TRUE(read.has_time);
  EXPECT_EQ(read.t_utc, 1756402221'749542955);
}

TEST(ubx, a_fix_is_what_the_receiver_says) {
  UbxReader reader;
  const auto fixes = read(reader, pvt());
  ASSERT_EQ(fixes.size(), 1u);
  expect_the_fix(fixes[0]);
  EXPECT_NEAR(fixes[0].fix.sigma_horizontal_m, 0.0098995, 1e-6);
  EXPECT_EQ(reader.counters().bytes_outside, 0u);
}

TEST(ubx, flags_are_the_kind_of_fix) {
  const std::pair<uint8_t, GnssFixType> kFlags[] = {{131, GnssFixType::kFixed},
                                                    {67, GnssFixType::kFloat},
                                                    {1, GnssFixType::k3d},
                                                    {0, GnssFixType::kNone}};
  for (const auto& [flags, type] : kFlags) {
    UbxReader reader;
    const auto fixes = read(reader, pvt(1, flags));
    ASSERT_EQ(fixes.size(), 1u);
    EXPECT_EQ(fixes[0].fix.type, type);
  }
}

TEST(ubx, a_covariance_that_follows_is_waited_for) {
  UbxReader reader;
  EXPECT_EQ(read(reader, pvt(1000)).size(), 1u);  // nobody knows yet that one follows
  EXPECT_EQ(read(reader, cov(1000)).size(), 0u);
  EXPECT_EQ(read(reader, pvt(1250)).size(), 0u);
  const auto fixes = read(reader, cov(1250));
  ASSERT_EQ(fixes.size(), 1u);
  expect_the_fix(fixes[0]);
  EXPECT_NEAR(fixes[0].fix.sigma_horizontal_m, std::sqrt(0.1), 1e-6);
  EXPECT_NEAR(fixes[0].fix.sigma_vertical_m, 0.5, 1e-6);
  EXPECT_NEAR(fixes[0].fix.sigma_velocity_m_s, 0.1, 1e-6);
  // It stays away: the fix is overtaken by the next one, which waits no more.
  EXPECT_EQ(read(reader, pvt(1500)).size(), 0u);
  EXPECT_EQ(read(reader, pvt(1750)).size(), 1u);
  EXPECT_EQ(reader.counters().fixes_overtaken, 1u);
  EXPECT_EQ(read(reader, cov(1750)).size(), 0u);
  EXPECT_EQ(read(reader, pvt(2000)).size(), 0u);
  ReceiverFix rest;
  EXPECT_TRUE(reader.flush(rest));
  EXPECT_FALSE(reader.flush(rest));
}

TEST(ubx, garbage_is_counted_and_costs_no_frame) {
  std::mt19937 random(3);
  for (int run = 0; run < 50; ++run) {
    UbxReader reader;
    Bytes bytes;
    size_t garbage = 0;
    for (int i = 0; i < 20; ++i) {
      const size_t size = random() % 60;
      for (size_t k = 0; k < size; ++k) bytes.push_back(uint8_t(random() % 180));  // no sync
      garbage += size;
      const Bytes good = pvt(uint32_t(i));
      bytes.insert(bytes.end(), good.begin(), good.end());
    }
    EXPECT_EQ(read(reader, bytes).size(), 20u);
    EXPECT_EQ(reader.counters().bytes_outside, garbage);
  }
}

// A frame that is cut off hides what begins within the length it claims, until that is disproved.
TEST(ubx, a_frame_cut_off_hides_none) {
  const Bytes good = pvt();
  for (size_t cut = 1; cut < good.size(); ++cut) {
    UbxReader reader;
    Bytes bytes(good.begin(), good.begin() + std::ptrdiff_t(cut));
    for (int i = 0; i < 40; ++i) bytes.insert(bytes.end(), good.begin(), good.end());
    EXPECT_EQ(read(reader, bytes).size(), 40u) << cut;
    EXPECT_EQ(reader.counters().bytes_outside, cut);
  }
}

TEST(ubx, a_wrong_bit_is_no_fix) {
  const Bytes good = pvt();
  for (size_t bit = 0; bit < good.size() * 8; ++bit) {
    UbxReader reader;
    Bytes wrong = good;
    wrong[bit / 8] = uint8_t(wrong[bit / 8] ^ 1u << bit % 8);
    EXPECT_EQ(read(reader, wrong).size(), 0u) << bit;
    EXPECT_EQ(reader.counters().pvt, 0u);
  }
}

TEST(ubx, a_frame_longer_than_the_memory_is_garbage) {
  UbxReader reader;
  Bytes bytes = {0xb5, 0x62, 1, 7, 0xff, 0xff};
  const Bytes good = pvt();
  bytes.insert(bytes.end(), good.begin(), good.end());
  EXPECT_EQ(read(reader, bytes).size(), 1u);
  EXPECT_EQ(reader.counters().bytes_outside, 6u);
}

// Real bytes: 536 fixes among raw measurements, and what belongs to no frame.
TEST(ubx, a_walk_as_it_was_logged) {
  const char* const root = std::getenv("PIRVS_DATA");
  const std::string path = std::string(root ? root : "../shared/data") + "/gnss_walk/gnss.ubx";
  std::ifstream file(path, std::ios::binary);
  if (!file) GTEST_SKIP() << "no recording at " << path << ": set PIRVS_DATA";
  const Bytes bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto reader = std::make_unique<UbxReader>();
  const auto fixes = read(*reader, bytes);
  std::printf("%zu fixes, %u frames, %u bytes outside\n", fixes.size(),
              uint32_t{reader->counters().frames}, uint32_t{reader->counters().bytes_outside});
  EXPECT_EQ(fixes.size(), 536u);
  EXPECT_EQ(reader->counters().frames, 3400u);
  EXPECT_EQ(reader->counters().bytes_outside, 136199u);
  for (size_t i = 1; i < fixes.size(); ++i) {
    EXPECT_TRUE(fixes[i].has_time);
    EXPECT_NEAR(double(fixes[i].t_utc - fixes[i - 1].t_utc), 250e6, 20e6) << i;
  }
}

}  // namespace
}  // namespace pirvs
