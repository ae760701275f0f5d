// One channel of the RK3399's PWM; channels are 16 bytes apart. In, Out nothing: rows and bits.
// Errors  none.
// Source  Rockchip RK3399 TRM V1.3 part 1, chapter "PWM". In continuous, left-aligned mode the
//         output has the duty polarity while CNT < DUTY_LPR, the opposite up to PERIOD_HPR.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::rk3399_pwm {

inline constexpr Register kCNT = {"PWM_CNT", 0x0, Access::kReadOnly, 0};
inline constexpr Register kPERIOD_HPR = {"PWM_PERIOD_HPR", 0x4, Access::kReadWrite, 0};
inline constexpr Register kDUTY_LPR = {"PWM_DUTY_LPR", 0x8, Access::kReadWrite, 0};
inline constexpr Register kCTRL = {"PWM_CTRL", 0xc, Access::kReadWrite, 0};

inline constexpr Register kRegisters[] = {kCNT, kPERIOD_HPR, kDUTY_LPR, kCTRL};
static_assert(is_table(kRegisters));

inline constexpr uint32_t kCtrlEnable = 1u << 0, kCtrlContinuous = 1u << 1,
                          kCtrlDutyPositive = 1u << 3, kCtrlInactivePositive = 1u << 4;

}  // namespace pirvs::bsp::rk3399_pwm
