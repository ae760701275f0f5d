// The one value of gravity: W has z up, so gravity is (0, 0, -kGravity_m_s2).
#pragma once

namespace pirvs {

inline constexpr double kGravity_m_s2 = 9.81;

}  // namespace pirvs
