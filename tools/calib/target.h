// What    A calibration board: squares of known size in a known grid; flat, or bent as its views
//         have shown.
// In      Kalibr's target.yaml: target_type aprilgrid, tagCols, tagRows, tagSize, tagSpacing.
// Out     Places of corners. A corner's id is 4 * tag + corner; tags count by rows from the bottom
//         left one, corners 0..3 counter-clockwise from the bottom left one.
// Frames  T: on the board, x right, y up, z towards the viewer; the origin is corner 0 of tag 0.
// Units   m; tagSpacing: gap between tags over the size of a tag.
// Errors  InputError naming file and key.
// Source  Kalibr wiki, "Calibration targets".
#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"

namespace pirvs::tools {

inline constexpr int kTagsMax = 587;  // of the family 36h11

struct Target {
  int columns = 6;
  int rows = 6;
  double tag_m = 0.088;  // black square, edge to edge
  double spacing = 0.3;  // gap over tag
  // How far each tag is from its place on a flat board, by tag; empty: it is flat.
  std::vector<Vec3> shift_T;

  int tags() const { return columns * rows; }
  int corners() const { return 4 * tags(); }
  double pitch_m() const { return tag_m * (1 + spacing); }
  Vec3 p_T(int corner) const;
  Vec3 tag_T(int tag) const { return (p_T(4 * tag) + p_T(4 * tag + 2)) / 2; }
  Vec3 middle_T() const { return (p_T(0) + p_T(corners() - 2)) / 2; }
  double diagonal_m() const { return (p_T(0) - p_T(corners() - 2)).norm(); }
};

Target read_target(const std::string& path);
void write_target(const Target& target, const std::string& path);

}  // namespace pirvs::tools
