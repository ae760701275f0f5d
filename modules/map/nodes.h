// Named places of the map that programs set and ask for again: a dock, a shelf. A node is fixed to
// the keyframe next to it, so that it goes along when the map is corrected.
// In      a map at rest; a pose in W, and the epoch that it belongs to.
// Out     the pose in W, as the map has it now.
// Frames  W; K: the body at a keyframe; N: the node.
// Errors  kBadData: a name that is empty, too long, or of other than letters, digits and . _ -.
//         kNotFound: no such node, or the map has no keyframe of that epoch. kFull: kNodesMax.
// Cost    set_node, carry_nodes: one pass over the keyframes; 112 bytes a node.
// Source  own; as static nodes of the T265.
#pragma once

#include "core/base/status.h"
#include "modules/map/map.h"

namespace pirvs {

bool is_node_name(const char* name);
// In place of the node of that name, if there is one.
Status set_node(Map& map, const char* name, const SE3& T_WN, uint16_t epoch);
Result<SE3> node_pose(const Map& map, const char* name);
Status remove_node(Map& map, const char* name);
// Before a keyframe leaves: its nodes go to the one next to it. Without another they leave too.
void carry_nodes(Map& map, KeyframeId leaving);

}  // namespace pirvs
