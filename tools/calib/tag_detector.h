// What    Finds the tags of a board in an image, their corners to a fraction of a pixel.
// In      8-bit grey. A board of either border (tag_family.h), in part or whole.
// Out     Corners by id, four of each tag: ids that are not on the board, tags seen twice, at
//         the image's rim or whose corners will not settle are dropped and counted.
// Units   px, (0,0) at the centre of the first pixel; corner ids as target.h.
// Errors  none; no tag, no corners.
// Cost    ~35 ms for 752 x 480 of one core. One object belongs to one thread.
// Source  libapriltag; corners as crossings of two edges by OpenCV's cornerSubPix (Förstner, Gülch,
//         1987).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "tools/calib/tag_family.h"
#include "tools/calib/target.h"
#include "tools/calib/views.h"

namespace pirvs::tools {

class TagDetector {
 public:
  explicit TagDetector(const Target& target);
  ~TagDetector();
  TagDetector(const TagDetector&) = delete;
  TagDetector& operator=(const TagDetector&) = delete;

  struct Dropped {
    size_t unknown = 0, doubled = 0, at_rim = 0, unsettled = 0;
  };

  std::vector<Corner> find(const cv::Mat& grey, Dropped& dropped);

 private:
  Target target_;
  Family family_[2];
  apriltag_detector_t* detector_;
};

}  // namespace pirvs::tools
