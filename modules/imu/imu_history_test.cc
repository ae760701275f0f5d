#include "modules/imu/imu_history.h"

#include <gtest/gtest.h>

#include <memory>

#include "modules/testing.h"

namespace pirvs {
namespace {

constexpr TimeNs kStep_ns = 5'000'000;

struct Filled {
  explicit Filled(size_t count) {
    for (size_t i = 0; i < count; ++i) {
      imu->add(sway.imu(to_seconds(kStep_ns * static_cast<TimeNs>(i))));
    }
  }
  testing::Sway sway;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
};

TEST(imu_history, is_found_by_time_and_keeps_the_newest) {
  Filled f(ImuHistory::kCapacity + 100);
  const ImuHistory& imu = *f.imu;
  EXPECT_EQ(imu.begin(), 100u);
  EXPECT_EQ(imu.newest().t, kStep_ns * static_cast<TimeNs>(ImuHistory::kCapacity + 99));
  EXPECT_EQ(imu.first_at(kStep_ns * 500), 500u);
  EXPECT_EQ(imu.first_at(kStep_ns * 500 - 1), 500u);
  EXPECT_EQ(imu.first_at(kStep_ns * 500 + 1), 501u);
  EXPECT_EQ(imu.first_at(0), imu.begin());
  EXPECT_EQ(imu.first_at(imu.newest().t + 1), imu.end());
  EXPECT_TRUE(imu.covers(kStep_ns * 100));
  EXPECT_FALSE(imu.covers(kStep_ns * 100 - 1)) << "that sample was overwritten";
}

TEST(imu_history, clear_forgets_all) {
  Filled f(10);
  f.imu->clear();
  EXPECT_TRUE(f.imu->empty());
  EXPECT_FALSE(f.imu->covers(0));
  EXPECT_EQ(f.imu->first_at(0), f.imu->end());
  const Preintegration none = integrate(*f.imu, 0, kStep_ns * 9, Vec3::Zero(), Vec3::Zero(), {});
  EXPECT_EQ(none.dt_s, 0);
}

TEST(imu_history, integrates_between_two_of_its_times_alone) {
  Filled f(400);
  ImuNoise noise;
  noise.rate_hz = 200;
  const Preintegration motion =
      integrate(*f.imu, kStep_ns * 100, kStep_ns * 300, Vec3::Zero(), Vec3::Zero(), noise);
  const Preintegration expected = f.sway.between(0.5, 1.5, noise);
  EXPECT_NEAR(motion.dt_s, 1.0, 1e-9);
  EXPECT_LT((motion.dp - expected.dp).norm(), 1e-9);
  EXPECT_LT((motion.dR - expected.dR).norm(), 1e-9);
}

}  // namespace
}  // namespace pirvs
