// What    Tags of the family 36h11 as boards have them: with a border of one bit, as AprilTag's
//         own, or of two, as Kalibr's.
// In      How many bits the border has.
// Out     libapriltag's family, to be owned; is_white: the bit in column x, row y of a tag, border
//         included, counted from the top left.
// Errors  none.
// Source  Olson, ICRA 2011; libapriltag 3.3.
#pragma once

#include <apriltag/apriltag.h>

#include <memory>

namespace pirvs::tools {

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const;
};
using Family = std::unique_ptr<apriltag_family_t, FamilyDeleter>;

Family make_family(int border_bits);
bool is_white(const apriltag_family_t& family, int tag, int x, int y);

}  // namespace pirvs::tools
