// The emulated bus and the access rules of an emulated register.
#include <gtest/gtest.h>

#include "bsp/api/mmio.h"
#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/emulated/register_file.h"

namespace pirvs::bsp::emulated {
namespace {

constexpr Register kPlain = {"PLAIN", 0x0, Access::kReadWrite, 7};
constexpr Register kStatus = {"STATUS", 0x4, Access::kReadOnly, 0};
constexpr Register kClear = {"CLEAR", 0x8, Access::kWriteOnly, 0};
constexpr Register kPending = {"PENDING", 0xc, Access::kClearByOne, 0};
constexpr Register kMux = {"MUX", 0x10, Access::kHiwordMask, 0x1234};
constexpr Register kRows[] = {kPlain, kStatus, kClear, kPending, kMux};
static_assert(is_table(kRows));

constexpr Register kUnsorted[] = {kStatus, kPlain};
constexpr Register kOdd[] = {{"ODD", 0x2, Access::kReadWrite, 0}};
static_assert(!is_table(kUnsorted) && !is_table(kOdd));

struct TestChip {
  static constexpr uint32_t kSize = 0x14;
  RegisterFile file{kRows};
  uint32_t read(uint32_t offset) { return file.load(offset); }
  void write(uint32_t offset, uint32_t value) { file.store(offset, value); }
};

TEST(EmulatedBus, EachChipAnswersAtItsOwnAddresses) {
  TestChip first, second;
  const Attachment at_first(0x1000, first), at_second(0x1014, second);
  mmio_write32(0x1000, 1);
  mmio_write32(0x1014, 2);
  EXPECT_EQ(mmio_read32(0x1000), 1u);
  EXPECT_EQ(mmio_read32(0x1014), 2u);
}

TEST(EmulatedBus, AChipIsGoneWithItsAttachment) {
  TestChip chip;
  { const Attachment here(0x1000, chip); }
  EXPECT_DEATH(mmio_read32(0x1000), "bug");
}

TEST(EmulatedBus, RefusesWhatNoBusAllows) {
  TestChip chip, other;
  const Attachment here(0x1000, chip);
  EXPECT_DEATH(mmio_read32(0x0ffc), "bug");
  EXPECT_DEATH(mmio_read32(0x1014), "bug");
  EXPECT_DEATH(mmio_read32(0x1002), "bug");
  EXPECT_DEATH(Attachment(0x1010, other), "bug");
}

TEST(RegisterFile, FollowsTheRuleOfEachRow) {
  TestChip chip;
  const Attachment here(0x1000, chip);
  const Registers registers(0x1000);
  EXPECT_EQ(registers.read(kPlain), 7u);
  registers.change(kPlain, 0x6, 0x10);
  EXPECT_EQ(registers.read(kPlain), 1u);
  chip.file.poke(kPending, 0x0f);
  registers.write(kPending, 0x05);
  EXPECT_EQ(registers.read(kPending), 0x0au);
  registers.write(kMux, hiword(0x00f0, 0x00a0));
  EXPECT_EQ(registers.read(kMux), 0x12a4u);
  registers.write(kMux, 0x0000ffff);  // no mask, no change
  EXPECT_EQ(registers.read(kMux), 0x12a4u);
  chip.file.reset();
  EXPECT_EQ(registers.read(kMux), 0x1234u);
}

TEST(RegisterFile, RefusesWhatTheManualForbids) {
  TestChip chip;
  const Attachment here(0x1000, chip);
  const Registers registers(0x1000);
  EXPECT_DEATH(registers.write(kStatus, 1), "bug");
  EXPECT_DEATH(registers.read(kClear), "bug");
  EXPECT_DEATH(registers.read({"NOWHERE", 0x14, Access::kReadWrite, 0}), "bug");
}

}  // namespace
}  // namespace pirvs::bsp::emulated
