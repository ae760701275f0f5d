// The pose part of an information filter: A = sum J' R^-1 J, b = sum J' R^-1 r.
// Frames  theta in B (right), p in W. Units: rad, m.
// Errors  none.
// Source  docs/conventions.md, "The update, iterated, in information form".
#pragma once

#include "core/math/types.h"

namespace pirvs {

struct PoseInformation {
  Mat6 A = Mat6::Zero();
  Vec6 b = Vec6::Zero();
};

}  // namespace pirvs
