// A pose as a line of text: `t x y z qx qy qz qw`, as the TUM trajectory format has it.
// Frames  T_WB; q is that of R_WB, Hamilton.
// Units   s with nine decimals, m.
// Errors  What does not fit is left out; the writer says so.
// Cost    ~1 us.
// Source  TUM RGB-D benchmark, "File formats".
#pragma once

#include "core/base/text.h"
#include "core/base/time.h"
#include "core/math/se3.h"

namespace pirvs {

inline constexpr size_t kPoseTextMax = 256;

void put_tum(TextWriter& out, TimeNs t, const SE3& T_WB);

}  // namespace pirvs
