#include "tools/calib/tag_family.h"

#include <apriltag/tag36h11.h>

namespace pirvs::tools {

void FamilyDeleter::operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }

Family make_family(int border_bits) {
  Family out(tag36h11_create());
  const int more = border_bits - 1;
  out->width_at_border += 2 * more;
  out->total_width += 2 * more;
  for (uint32_t i = 0; i < out->nbits; ++i) {
    out->bit_x[i] += uint32_t(more);
    out->bit_y[i] += uint32_t(more);
  }
  return out;
}

bool is_white(const apriltag_family_t& family, int tag, int x, int y) {
  const uint64_t code = family.codes[tag];
  for (uint32_t i = 0; i < family.nbits; ++i) {
    if (int(family.bit_x[i]) != x || int(family.bit_y[i]) != y) continue;
    return (code >> (family.nbits - 1 - i) & 1) != 0;
  }
  return false;
}

}  // namespace pirvs::tools
