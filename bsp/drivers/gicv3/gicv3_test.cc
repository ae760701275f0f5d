#include "bsp/drivers/gicv3/gicv3.h"

#include <gtest/gtest.h>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/gicv3/gicv3_emulator.h"

namespace pirvs::bsp {
namespace {

// Cores as on an RK3399, two clusters, and one with every affinity byte set.
constexpr uint64_t kMpidr[] = {0x8000'0000, 0x8000'0001, 0x8000'0100, 0x01'8002'0300};

class GicV3Driver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0x0800'0000;
  emulated::GicV3Chip chip_{{0x0000'0000, 0x0000'0001, 0x0000'0100, 0x0102'0300}};
  emulated::Attachment attachment_{kBase, chip_};
  GicV3 driver_{kBase, kBase + emulated::GicV3Chip::kRedistributors, 4};

  int count_passing(int core) const {
    int count = 0;
    for (uint32_t i = 0; i < emulated::GicV3Chip::kInterrupts; ++i) count += chip_.passes(i, core);
    return count;
  }
};

TEST_F(GicV3Driver, AfterTheStartOnlyMessagesPass) {
  driver_.start();
  for (int core = 0; core < 4; ++core) {
    EXPECT_EQ(count_passing(core), 0);
    ASSERT_EQ(driver_.start_core(kMpidr[core]), Status::kOk);
    EXPECT_EQ(count_passing(core), 16);
    EXPECT_TRUE(chip_.passes(0, core));
    EXPECT_TRUE(chip_.passes(15, core));
  }
}

TEST_F(GicV3Driver, ACoresOwnInterruptPassesOnThatCoreAlone) {
  driver_.start();
  for (const uint64_t mpidr : kMpidr) ASSERT_EQ(driver_.start_core(mpidr), Status::kOk);
  ASSERT_EQ(driver_.enable(27, kMpidr[2]), Status::kOk);
  for (int core = 0; core < 4; ++core) EXPECT_EQ(chip_.passes(27, core), core == 2);
}

TEST_F(GicV3Driver, ADevicesInterruptGoesToTheCoreAskedFor) {
  driver_.start();
  for (const uint64_t mpidr : kMpidr) ASSERT_EQ(driver_.start_core(mpidr), Status::kOk);
  ASSERT_EQ(driver_.enable(39, kMpidr[0]), Status::kOk);
  ASSERT_EQ(driver_.enable(95, kMpidr[3]), Status::kOk);
  for (int core = 0; core < 4; ++core) {
    EXPECT_EQ(chip_.passes(39, core), core == 0);
    EXPECT_EQ(chip_.passes(95, core), core == 3);
    EXPECT_FALSE(chip_.passes(40, core));
  }
}

TEST_F(GicV3Driver, SaysWhenThereIsNoSuchCoreOrItSleeps) {
  driver_.start();
  EXPECT_EQ(driver_.start_core(0x8000'0007), Status::kNotFound);
  EXPECT_EQ(driver_.enable(39, 0x8000'0007), Status::kNotFound);
  chip_.wakes_up = false;
  EXPECT_EQ(driver_.start_core(kMpidr[1]), Status::kTimeout);
}

}  // namespace
}  // namespace pirvs::bsp
