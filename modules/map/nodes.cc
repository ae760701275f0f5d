#include "modules/map/nodes.h"

#include <cstring>
#include <limits>

namespace pirvs {
namespace {

Node* find_node(FixedVector<Node, kNodesMax>& nodes, const char* name) {
  for (Node& node : nodes) {
    if (std::strcmp(node.name, name) == 0) return &node;
  }
  return nullptr;
}

void erase(FixedVector<Node, kNodesMax>& nodes, Node* node) {
  *node = nodes.back();
  nodes.pop_back();
}

// Fixes the node to the keyframe of that epoch that is next to it.
Status tie(const Map& map, const SE3& T_WN, uint16_t epoch, KeyframeId without, Node& node) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t slot = 0; slot < map.keyframes.capacity(); ++slot) {
    const Keyframe* keyframe = map.keyframes.at(slot);
    if (keyframe == nullptr || keyframe->epoch != epoch) continue;
    const KeyframeId id = map.keyframes.handle(slot);
    const double distance = (keyframe->state.T_WB.p - T_WN.p).norm();
    if (id == without || distance >= least) continue;
    least = distance;
    node.keyframe = id;
    node.T_KN = keyframe->state.T_WB.inverse() * T_WN;
  }
  return least < std::numeric_limits<double>::infinity() ? Status::kOk : Status::kNotFound;
}

}  // namespace

bool is_node_name(const char* name) {
  size_t size = 0;
  for (const char* at = name; *at != '\0'; ++at, ++size) {
    const char c = *at;
    const bool good = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                      c == '.' || c == '_' || c == '-';
    if (!good) return false;
  }
  return size > 0 && size < kNodeName;
}

Status set_node(Map& map, const char* name, const SE3& T_WN, uint16_t epoch) {
  if (!is_node_name(name) || !T_WN.R.allFinite() || !T_WN.p.allFinite()) return Status::kBadData;
  Node node;
  std::memcpy(node.name, name, std::strlen(name));
  PIRVS_TRY(tie(map, T_WN, epoch, KeyframeId{}, node));
  Node* const same = find_node(map.nodes, name);
  if (same != nullptr) {
    *same = node;
    return Status::kOk;
  }
  return map.nodes.push_back(node) ? Status::kOk : Status::kFull;
}

Result<SE3> node_pose(const Map& map, const char* name) {
  for (const Node& node : map.nodes) {
    const Keyframe* const keyframe = map.keyframes.find(node.keyframe);
    if (std::strcmp(node.name, name) != 0 || keyframe == nullptr) continue;
    return keyframe->state.T_WB * node.T_KN;
  }
  return Status::kNotFound;
}

Status remove_node(Map& map, const char* name) {
  Node* const node = find_node(map.nodes, name);
  if (node == nullptr) return Status::kNotFound;
  erase(map.nodes, node);
  return Status::kOk;
}

void carry_nodes(Map& map, KeyframeId leaving) {
  const Keyframe* const keyframe = map.keyframes.find(leaving);
  if (keyframe == nullptr) return;
  for (size_t i = 0; i < map.nodes.size();) {
    Node& node = map.nodes[i];
    const bool stays =
        node.keyframe != leaving ||
        tie(map, keyframe->state.T_WB * node.T_KN, keyframe->epoch, leaving, node) == Status::kOk;
    if (stays) {
      ++i;
    } else {
      erase(map.nodes, &node);
    }
  }
}

}  // namespace pirvs
