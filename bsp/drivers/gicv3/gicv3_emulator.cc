#include "bsp/drivers/gicv3/gicv3_emulator.h"

#include "core/base/assert.h"

namespace pirvs::bsp::emulated {

using namespace gicv3;

namespace {

constexpr int kReadsUntilWritten = 3;
constexpr uint32_t kPriorityMask = 0xff;  // of what the interface lets through: all but idle

// The place in an array of `count` words that begins at `row`, or -1.
int index_in(const Register& row, uint32_t count, uint32_t offset) {
  if (offset < row.offset || offset >= row.offset + 4 * count) return -1;
  return static_cast<int>((offset - row.offset) / 4);
}

}  // namespace

GicV3Chip::GicV3Chip(const uint32_t (&affinities)[kCores]) {
  for (int i = 0; i < kCores; ++i) cores_[i].affinity = affinities[i];
}

uint32_t GicV3Chip::read(uint32_t offset) {
  if (offset >= kRedistributors) {
    const uint32_t at = offset - kRedistributors;
    return read_core(cores_[at / kRedistributorBytes], at % kRedistributorBytes);
  }
  if (offset == kGICD_CTLR.offset) {
    const bool busy = writes_on_their_way_ > 0 && --writes_on_their_way_ > 0;
    return control_ | (busy ? kGicdCtlrRwp : 0);
  }
  PIRVS_ASSERT(offset == kGICD_TYPER.offset);
  return kWords - 1;
}

void GicV3Chip::write(uint32_t offset, uint32_t value) {
  if (offset >= kRedistributors) {
    const uint32_t at = offset - kRedistributors;
    write_core(cores_[at / kRedistributorBytes], at % kRedistributorBytes, value);
    return;
  }
  if (offset == kGICD_CTLR.offset) {
    control_ = value;
    writes_on_their_way_ = kReadsUntilWritten;
    return;
  }
  int i = -1;
  if ((i = index_in(kGICD_IGROUPR, kWords, offset)) > 0) {
    group_[i] = value;
  } else if ((i = index_in(kGICD_ISENABLER, kWords, offset)) > 0) {
    enabled_[i] |= value;
  } else if ((i = index_in(kGICD_ICENABLER, kWords, offset)) > 0) {
    enabled_[i] &= ~value;
  } else if ((i = index_in(kGICD_IPRIORITYR, kInterrupts / 4, offset)) >= 8) {
    priority_[i] = value;
  } else if ((i = index_in(kGICD_IROUTER, 2 * kInterrupts, offset)) >= 64) {
    route_[i] = value;
  } else {
    PIRVS_ASSERT(!"a register of the distributor that the driver may write");
  }
}

uint32_t GicV3Chip::read_core(Core& core, uint32_t offset) const {
  if (offset == kGICR_TYPER_HIGH.offset) return core.affinity;
  PIRVS_ASSERT(offset == kGICR_WAKER.offset);
  const uint32_t now = core.waker;
  const bool called = (core.waker & kGicrWakerProcessorSleep) == 0;
  if (called && wakes_up) core.waker &= ~kGicrWakerChildrenAsleep;
  return now;
}

void GicV3Chip::write_core(Core& core, uint32_t offset, uint32_t value) const {
  if (offset == kGICR_WAKER.offset) {
    core.waker = (core.waker & kGicrWakerChildrenAsleep) | (value & kGicrWakerProcessorSleep);
    return;
  }
  PIRVS_ASSERT((core.waker & kGicrWakerChildrenAsleep) == 0);
  if (offset == kGICR_IGROUPR0.offset) {
    core.group = value;
  } else if (offset == kGICR_ISENABLER0.offset) {
    core.enabled |= value;
  } else if (offset == kGICR_ICENABLER0.offset) {
    core.enabled &= ~value;
  } else {
    const int i = index_in(kGICR_IPRIORITYR, 8, offset);
    PIRVS_ASSERT(i >= 0);
    core.priority[i] = value;
  }
}

bool GicV3Chip::passes(uint32_t intid, int core) const {
  PIRVS_ASSERT(intid < kInterrupts && core >= 0 && core < kCores);
  const Core& mine = cores_[core];
  const bool is_own = intid < 32;
  const uint32_t enabled = is_own ? mine.enabled : enabled_[intid / 32];
  const uint32_t group = is_own ? mine.group : group_[intid / 32];
  const uint32_t priorities = is_own ? mine.priority[intid / 4] : priority_[intid / 4];
  const uint32_t priority = priorities >> 8 * (intid % 4) & 0xff;
  const bool awake = (mine.waker & kGicrWakerChildrenAsleep) == 0;
  const bool on = (control_ & kGicdCtlrEnableGrp1) != 0 && (control_ & kGicdCtlrAre) != 0;
  const uint32_t affinity = route_[2 * intid] | route_[2 * intid + 1] << 24;
  const bool routed = is_own || affinity == mine.affinity;
  const uint32_t bit = 1u << intid % 32;
  return on && awake && routed && (enabled & bit) != 0 && (group & bit) != 0 && priority != 0 &&
         priority < kPriorityMask;
}

}  // namespace pirvs::bsp::emulated
