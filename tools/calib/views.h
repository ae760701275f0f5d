// What    Corners of a board as a camera saw them, and the pairs of a stereo camera.
// In      A table, a corner a row: `timestamp [ns], tag_id, corner, x [px], y [px]`.
// Out     Views in order of time, corners in order of their ids, each id once.
// Units   pixels with (0,0) at the centre of the first pixel; corner ids as in target.h.
// Errors  InputError: cannot be read, no corners, most ids are not on the board. Rejected and
//         counted by name: unknown ids, ids seen twice in one image, corners outside the image.
// Cost    ~0.2 s for 180,000 rows.
#pragma once

#include <string>
#include <vector>

#include "core/base/time.h"
#include "tools/calib/target.h"
#include "tools/dataset/input_log.h"

namespace pirvs::tools {

struct Corner {
  int id = 0;
  Vec2 uv;
};

struct SeenTag {
  int id = 0;
  Vec2 uv;  // the mean of its four corners (tag_image.h says why)
};

struct View {
  TimeNs t = 0;
  std::vector<SeenTag> tags;  // by id
};

struct ImageSize {
  int width = 0;
  int height = 0;
};

// Whole tags of an image; corners are put in order. One that is there twice is a reflection or a
// second board: which one is ours nobody knows, so that tag goes.
struct TagCounts {
  size_t doubled = 0, partial = 0;
};
View whole_tags(TimeNs t, std::vector<Corner>& corners, TagCounts& counts);

std::vector<View> read_views(const std::string& path, const Target& target, ImageSize size,
                             InputLog& log);

// What a stereo camera saw at one instant; a view without tags: that camera saw nothing.
struct Shot {
  TimeNs t = 0;
  View view[2];
};

// Pairs views whose stamps differ by less than half of the least step of `left`.
std::vector<Shot> pair_views(const std::vector<View>& left, const std::vector<View>& right);

}  // namespace pirvs::tools
