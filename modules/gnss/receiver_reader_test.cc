#include "modules/gnss/receiver_reader.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "modules/gnss/nmea_sentence_test.h"

namespace pirvs {
namespace {

// NAV-PVT of a second after noon, with the height in m.
std::string pvt(int second, int height_m) {
  std::string out(100, '\0');
  const auto put = [&out](size_t at, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out[at + size_t(i)] = char(value >> 8 * i & 0xff);
  };
  constexpr size_t kPayload = 6;
  put(0, 0x62b5, 2);
  put(2, 0x0701, 2);
  put(4, 92, 2);
  put(kPayload, 1000 * uint32_t(second), 4);
  put(kPayload + 4, 2026, 2);
  out[kPayload + 6] = 11, out[kPayload + 7] = 26, out[kPayload + 8] = 12;
  out[kPayload + 10] = char(second), out[kPayload + 11] = 7;
  out[kPayload + 20] = 3, out[kPayload + 21] = 1;
  put(kPayload + 32, 1000 * uint32_t(height_m), 4);
  uint8_t a = 0, b = 0;
  for (size_t i = 2; i < 98; ++i) {
    a = uint8_t(a + uint8_t(out[i]));
    b = uint8_t(b + a);
  }
  put(98, a, 1);
  put(99, b, 1);
  return out;
}

std::string nmea(int second, int height_m) {
  char text[120];
  std::snprintf(text, sizeof text, "GNGGA,1200%02d.00,4723.86,N,00832.736,E,4,12,0.6,%d,M,0,M,,",
                second, height_m);
  return testing::sentence(text);
}

std::vector<double> heights(ReceiverReader& reader, const std::string& bytes) {
  std::vector<double> out;
  ReceiverFix fix;
  for (const char c : bytes) {
    if (reader.take(uint8_t(c), fix)) out.push_back(fix.fix.height_m);
  }
  return out;
}

TEST(receiver_reader, each_language_alone) {
  ReceiverReader ubx, text;
  EXPECT_EQ(heights(ubx, pvt(1, 10) + pvt(2, 11)), (std::vector<double>{10, 11}));
  EXPECT_EQ(heights(text, nmea(1, 20) + nmea(2, 21) + nmea(3, 22)),
            (std::vector<double>{20, 21, 22}));
}

TEST(receiver_reader, of_both_at_once_ubx_counts) {
  ReceiverReader reader;
  std::string bytes;
  for (int k = 0; k < 10; ++k) bytes += pvt(k, 10) + nmea(k, 20);
  EXPECT_EQ(heights(reader, bytes), std::vector<double>(10, 10));
  bytes.clear();
  for (int k = 10; k < 20; ++k) bytes += nmea(k, 20);
  EXPECT_GE(heights(reader, bytes).size(), 6u) << "UBX was switched off";
}

}  // namespace
}  // namespace pirvs
