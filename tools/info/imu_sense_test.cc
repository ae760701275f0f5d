#include "tools/info/imu_sense.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/math/so3.h"

namespace pirvs::tools {
namespace {

// A body that tilts and shakes, sensed at 200 Hz for 8 s.
std::vector<ImuSample> samples(double turn_rad_s = 0.5, double shake_m_s2 = 1) {
  std::vector<ImuSample> out;
  Mat3 R_WB = Mat3::Identity();
  for (int i = 0; i < 1600; ++i) {
    const double t = i * 0.005;
    const Vec3 w(turn_rad_s * std::sin(1.3 * t), turn_rad_s * std::cos(0.9 * t), 0.2);
    const Vec3 a(shake_m_s2 * std::sin(7 * t), shake_m_s2 * std::cos(5 * t), 0.3 * std::sin(9 * t));
    out.push_back({TimeNs(i) * 5'000'000, w, R_WB.transpose() * (a + Vec3(0, 0, 9.81))});
    R_WB = R_WB * so3_exp(0.005 * w);
  }
  return out;
}

std::string found(std::vector<ImuSample> all,
                  const std::function<void(ImuSample&, size_t)>& spoil) {
  for (size_t i = 0; i < all.size(); ++i) spoil(all[i], i);
  const ImuFault fault = find_imu_fault(all);
  return fault.what + ": " + fault.what_to_do;
}

TEST(imu_sense, says_nothing_of_what_can_be) {
  const auto as_it_is = [](ImuSample&, size_t) {};
  EXPECT_EQ(found(samples(), as_it_is), ": ");
  EXPECT_EQ(found(samples(0, 0), as_it_is), ": ");       // at rest, turning slowly
  EXPECT_EQ(found(samples(3, 6), as_it_is), ": ");       // a racing drone
  EXPECT_EQ(found(samples(0.01, 0.1), as_it_is), ": ");  // a car
}

TEST(imu_sense, names_what_cannot) {
  const std::pair<const char*, std::function<void(ImuSample&, size_t)>> cases[] = {
      {"not g:", [](ImuSample& s, size_t) { s.f_B /= 9.81; }},
      {"not mg", [](ImuSample& s, size_t) { s.f_B *= 1000 / 9.81; }},
      {"gravity is missing", [](ImuSample& s, size_t) { s.f_B *= 0.02; }},
      {"not deg/s", [](ImuSample& s, size_t) { s.w_B *= 57.29578; }},
      {"columns are exchanged", [](ImuSample& s, size_t) { std::swap(s.w_B, s.f_B); }},
      {"exactly 0", [](ImuSample& s, size_t i) {
         if (i % 4 != 0) s.f_B.setZero();
       }}};
  for (const auto& [says, spoil] : cases) {
    EXPECT_NE(found(samples(), spoil).find(says), std::string::npos) << found(samples(), spoil);
  }
}

}  // namespace
}  // namespace pirvs::tools
