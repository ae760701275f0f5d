// Arm's generic interrupt controller, version 3: registers in memory. The first of each array.
// Errors  none.
// Source  Arm IHI 0069, GIC Architecture Specification v3 and v4, chapter 12. A redistributor has
//         two frames of 64 KiB: its own, then that of SGIs and PPIs (INTID 0 to 31).
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::gicv3 {

inline constexpr Register kGICD_CTLR = {"GICD_CTLR", 0x0000, Access::kReadWrite, 0};
inline constexpr Register kGICD_TYPER = {"GICD_TYPER", 0x0004, Access::kReadOnly, 0};
inline constexpr Register kGICD_IGROUPR = {"GICD_IGROUPR", 0x0080, Access::kReadWrite, 0};
inline constexpr Register kGICD_ISENABLER = {"GICD_ISENABLER", 0x0100, Access::kReadWrite, 0};
inline constexpr Register kGICD_ICENABLER = {"GICD_ICENABLER", 0x0180, Access::kReadWrite, 0};
inline constexpr Register kGICD_IPRIORITYR = {"GICD_IPRIORITYR", 0x0400, Access::kReadWrite, 0};
inline constexpr Register kGICD_IROUTER = {"GICD_IROUTER", 0x6000, Access::kReadWrite, 0};

inline constexpr Register kGICR_CTLR = {"GICR_CTLR", 0x00000, Access::kReadWrite, 0};
inline constexpr Register kGICR_TYPER_HIGH = {"GICR_TYPER[63:32]", 0x0000c, Access::kReadOnly, 0};
inline constexpr Register kGICR_WAKER = {"GICR_WAKER", 0x00014, Access::kReadWrite, 0x6};
inline constexpr Register kGICR_IGROUPR0 = {"GICR_IGROUPR0", 0x10080, Access::kReadWrite, 0};
inline constexpr Register kGICR_ISENABLER0 = {"GICR_ISENABLER0", 0x10100, Access::kReadWrite, 0};
inline constexpr Register kGICR_ICENABLER0 = {"GICR_ICENABLER0", 0x10180, Access::kReadWrite, 0};
inline constexpr Register kGICR_IPRIORITYR = {"GICR_IPRIORITYR", 0x10400, Access::kReadWrite, 0};

inline constexpr Register kDistributor[] = {kGICD_CTLR,      kGICD_TYPER,     kGICD_IGROUPR,
                                            kGICD_ISENABLER, kGICD_ICENABLER, kGICD_IPRIORITYR,
                                            kGICD_IROUTER};
inline constexpr Register kRedistributor[] = {kGICR_CTLR,      kGICR_TYPER_HIGH, kGICR_WAKER,
                                              kGICR_IGROUPR0,  kGICR_ISENABLER0, kGICR_ICENABLER0,
                                              kGICR_IPRIORITYR};
static_assert(is_table(kDistributor) && is_table(kRedistributor));

inline constexpr uint32_t kGicdCtlrEnableGrp1 = 1u << 1;
inline constexpr uint32_t kGicdCtlrAre = 1u << 4;
inline constexpr uint32_t kGicdCtlrRwp = 1u << 31;  // a write is still on its way
inline constexpr uint32_t kGicrWakerProcessorSleep = 1u << 1;
inline constexpr uint32_t kGicrWakerChildrenAsleep = 1u << 2;
inline constexpr uint32_t kRedistributorBytes = 0x20000;

}  // namespace pirvs::bsp::gicv3
