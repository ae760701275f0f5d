#include "tools/calib/views.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/dataset/input_error.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

TimeNs least_step(const std::vector<View>& views) {
  TimeNs least = 1'000'000'000;
  for (size_t i = 1; i < views.size(); ++i) least = std::min(least, views[i].t - views[i - 1].t);
  return least;
}

}  // namespace

View whole_tags(TimeNs t, std::vector<Corner>& corners, TagCounts& counts) {
  std::sort(corners.begin(), corners.end(),
            [](const Corner& a, const Corner& b) { return a.id < b.id; });
  View out;
  out.t = t;
  for (size_t i = 0, end = 0; i < corners.size(); i = end) {
    const int tag = corners[i].id / 4;
    Vec2 sum = Vec2::Zero();
    bool twice = false;
    for (end = i; end < corners.size() && corners[end].id / 4 == tag; ++end) {
      twice = twice || (end > i && corners[end].id == corners[end - 1].id);
      sum += corners[end].uv;
    }
    if (twice) {
      ++counts.doubled;
    } else if (end - i < 4) {
      ++counts.partial;
    } else {
      out.tags.push_back({tag, sum / 4});
    }
  }
  return out;
}

std::vector<View> read_views(const std::string& path, const Target& target, ImageSize size,
                             InputLog& log) {
  std::map<TimeNs, std::vector<Corner>> found;
  size_t unknown = 0, outside = 0, rows = 0;
  TagCounts counts;
  TextTable table(path, "corners");
  while (table.next()) {
    const auto t = table.stamp();
    const auto tag = table.number(1), k = table.number(2), x = table.number(3), y = table.number(4);
    if (table.cut_off() && (!t || !y)) break;
    if (!t || !tag || !k || !x || !y) {
      table.fail("not a row of stamp, tag, corner, x, y",
                 "write corners as docs/calibration.md says");
    }
    ++rows;
    const bool on_board = *tag >= 0 && *tag < target.tags() && *k >= 0 && *k <= 3;
    if (!on_board || *tag != std::floor(*tag) || *k != std::floor(*k)) {
      ++unknown;
      continue;
    }
    if (!(*x >= -0.5 && *y >= -0.5 && *x <= size.width - 0.5 && *y <= size.height - 0.5)) {
      ++outside;
      continue;
    }
    found[*t].push_back({4 * int(*tag) + int(*k), Vec2(*x, *y)});
  }
  if (rows == 0) throw InputError("no corners", path, "was the board in view?");
  if (unknown > rows / 2) {
    throw InputError("most tags are not on the board", path,
                     "give the yaml of the board that was used");
  }
  if (outside > rows / 2) {
    throw InputError("most corners are outside the image", path, "give the --size of the images");
  }
  std::vector<View> out;
  for (auto& [t, corners] : found) {
    View view = whole_tags(t, corners, counts);
    if (!view.tags.empty()) out.push_back(std::move(view));
  }
  log.count("corners_with_an_unknown_id", unknown);
  log.count("corners_outside_the_image", outside);
  log.count("tags_with_corners_missing", counts.partial);
  log.count("tags_seen_twice", counts.doubled);
  return out;
}

std::vector<Shot> pair_views(const std::vector<View>& left, const std::vector<View>& right) {
  const TimeNs near = least_step(left) / 2;
  std::vector<Shot> out;
  size_t r = 0;
  for (const View& view : left) {
    for (; r < right.size() && right[r].t < view.t - near; ++r) {
      out.push_back({right[r].t, {View{}, right[r]}});
    }
    Shot shot{view.t, {view, View{}}};
    if (r < right.size() && right[r].t < view.t + near) shot.view[1] = right[r++];
    out.push_back(std::move(shot));
  }
  for (; r < right.size(); ++r) out.push_back({right[r].t, {View{}, right[r]}});
  return out;
}

}  // namespace pirvs::tools
