#include "bsp/drivers/gicv3/gicv3.h"

#include "bsp/drivers/gicv3/gicv3_registers.h"

namespace pirvs::bsp {

using namespace gicv3;

namespace {

constexpr uint32_t kFirstSpi = 32;
constexpr uint32_t kEvery = 0xffffffff;
constexpr uint32_t kMessages = 0xffff;      // INTID 0 to 15
constexpr uint32_t kPriority = 0xa0a0a0a0;  // one for all: handlers do not nest
constexpr int kTries = 100'000;             // accesses: some 10 ms

// Aff3 to Aff0 side by side, as GICR_TYPER has them; MPIDR has Aff3 8 bits further up.
constexpr uint32_t affinity(uint64_t mpidr) {
  return static_cast<uint32_t>((mpidr & 0xffffff) | (mpidr >> 8 & 0xff000000));
}

}  // namespace

void GicV3::wait_for_writes() const {
  for (int i = 0; i < kTries && (distributor_.read(kGICD_CTLR) & kGicdCtlrRwp) != 0; ++i) {
  }
}

void GicV3::start() const {
  distributor_.write(kGICD_CTLR, 0);
  wait_for_writes();
  const uint32_t words = (distributor_.read(kGICD_TYPER) & 0x1f) + 1;  // of 32 interrupts
  for (uint32_t i = 1; i < words; ++i) {  // word 0 is that of the cores' own interrupts
    distributor_.write_at(kGICD_ICENABLER, i, kEvery);
    distributor_.write_at(kGICD_IGROUPR, i, kEvery);
    for (uint32_t k = 8 * i; k < 8 * i + 8; ++k) {
      distributor_.write_at(kGICD_IPRIORITYR, k, kPriority);
    }
  }
  distributor_.write(kGICD_CTLR, kGicdCtlrAre | kGicdCtlrEnableGrp1);
  wait_for_writes();
}

Result<uintptr_t> GicV3::redistributor_of(uint64_t mpidr) const {
  for (int i = 0; i < count_; ++i) {
    const uintptr_t base = redistributors_ + static_cast<uintptr_t>(i) * kRedistributorBytes;
    if (Registers(base).read(kGICR_TYPER_HIGH) == affinity(mpidr)) return base;
  }
  return Status::kNotFound;
}

Status GicV3::start_core(uint64_t mpidr) const {
  const Result<uintptr_t> found = redistributor_of(mpidr);
  if (!found.ok()) return found.status();
  const Registers mine(found.value());
  mine.change(kGICR_WAKER, kGicrWakerProcessorSleep, 0);
  int tries = kTries;
  while ((mine.read(kGICR_WAKER) & kGicrWakerChildrenAsleep) != 0) {
    if (--tries == 0) return Status::kTimeout;
  }
  mine.write(kGICR_ICENABLER0, kEvery);
  mine.write(kGICR_IGROUPR0, kEvery);
  for (uint32_t i = 0; i < 8; ++i) mine.write_at(kGICR_IPRIORITYR, i, kPriority);
  mine.write(kGICR_ISENABLER0, kMessages);
  return Status::kOk;
}

Status GicV3::enable(uint32_t intid, uint64_t mpidr) const {
  const uint32_t bit = 1u << intid % 32;
  const Result<uintptr_t> found = redistributor_of(mpidr);
  if (!found.ok()) return found.status();
  if (intid < kFirstSpi) {
    Registers(found.value()).write(kGICR_ISENABLER0, bit);
    return Status::kOk;
  }
  distributor_.write_at(kGICD_IROUTER, 2 * intid, affinity(mpidr) & 0xffffff);
  distributor_.write_at(kGICD_IROUTER, 2 * intid + 1, affinity(mpidr) >> 24);
  distributor_.write_at(kGICD_ISENABLER, intid / 32, bit);
  return Status::kOk;
}

}  // namespace pirvs::bsp
