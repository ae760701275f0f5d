#include "bsp/drivers/rk3399_setup/rk3399_setup.h"

#include <gtest/gtest.h>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/emulated/register_file.h"

namespace pirvs::bsp {
namespace {

using namespace rk3399_setup;

constexpr SetupRow kRows[] = {
    {kGrf, kGPIO2A_IOMUX, 3 << 2, 1 << 2, "A1: one function"},
    {kGrf, kGPIO2A_IOMUX, 3 << 4, 1 << 4, "A2: another"},
    {kGrf, kGPIO4C_IOMUX, 3 << 4, 1 << 4, "C2: PWM_0"},
};
static_assert(is_setup(kRows));
constexpr SetupRow kOutside[] = {{kGrf, kGPIO2A_IOMUX, 3, 4, "outside its mask"}};
static_assert(!is_setup(kOutside));

constexpr Register kGrfRegisters[] = {kGPIO2A_IOMUX, kGPIO4C_IOMUX};

struct GrfChip {
  static constexpr uint32_t kSize = 0x1'0000;
  emulated::RegisterFile file{kGrfRegisters};
  uint32_t read(uint32_t offset) { return file.load(offset); }
  void write(uint32_t offset, uint32_t value) { file.store(offset, value); }
};

TEST(Rk3399Setup, WritesItsBitsAndLeavesTheOthers) {
  GrfChip grf;
  const emulated::Attachment here(kGrf, grf);
  grf.file.poke(kGPIO2A_IOMUX, 0xffff);
  apply(kRows);
  EXPECT_EQ(grf.file.peek(kGPIO2A_IOMUX), 0xffd7u);
  EXPECT_EQ(grf.file.peek(kGPIO4C_IOMUX), 0x0010u);
  size_t which = 0;
  EXPECT_EQ(holds(kRows, which), Status::kOk);
}

TEST(Rk3399Setup, SeesWhatAResetUndid) {
  GrfChip grf;
  const emulated::Attachment here(kGrf, grf);
  apply(kRows);
  grf.file.poke(kGPIO2A_IOMUX, 1 << 2);
  size_t which = 0;
  EXPECT_EQ(holds(kRows, which), Status::kBadData);
  EXPECT_EQ(which, 1u);
}

constexpr Register kPmuCruRegisters[] = {kPPLL_CON0, kPPLL_CON1, kPMU_CLKSEL_CON0};

struct PmuCruChip {
  static constexpr uint32_t kSize = 0x1'0000;
  emulated::RegisterFile file{kPmuCruRegisters};
  uint32_t read(uint32_t offset) { return file.load(offset); }
  void write(uint32_t offset, uint32_t value) { file.store(offset, value); }
};

TEST(Rk3399Setup, ReadsTheClockThatTheBootLoaderMade) {
  PmuCruChip pmucru;
  const emulated::Attachment here(kPmuCru, pmucru);
  EXPECT_EQ(pmu_pclk_hz(), 0u);  // after a reset: no dividers, no rate
  pmucru.file.poke(kPPLL_CON0, 169);
  pmucru.file.poke(kPPLL_CON1, 1 << 12 | 3 << 8 | 2);
  pmucru.file.poke(kPMU_CLKSEL_CON0, 13);
  EXPECT_EQ(pmu_pclk_hz(), 48'285'714u);  // 676 MHz / 14
}

}  // namespace
}  // namespace pirvs::bsp
