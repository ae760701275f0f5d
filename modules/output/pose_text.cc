#include "modules/output/pose_text.h"

#include "core/math/so3.h"

namespace pirvs {

void put_tum(TextWriter& out, TimeNs t, const SE3& T_WB) {
  constexpr TimeNs kSecond = 1'000'000'000;
  constexpr int kDecimals = 9;
  const Vec4 q_WB = quat_xyzw(T_WB.R);
  out.number(t / kSecond).put('.');
  out.unsigned_number(static_cast<uint64_t>(t % kSecond), kDecimals);
  for (int i = 0; i < 3; ++i) out.put(' ').fixed(T_WB.p(i), kDecimals);
  for (int i = 0; i < 4; ++i) out.put(' ').fixed(q_WB(i), kDecimals);
}

}  // namespace pirvs
