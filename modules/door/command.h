// What a user, a robot's link or a pin may ask of the running stack, and the answer. Commands come
// in by the door, so that a recording holds them and a replay obeys them again.
// Frames  W, B as everywhere.
// Units   m, rad.
// Errors  The answer's status is the outcome: kOk done; kNotFound no such name; kBadData a value
//         that is not allowed; kFull, kBusFault the storage refuses; kStale not possible in this
//         state.
// Cost    ~200 bytes a command.
// Source  own.
#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "core/math/se3.h"

namespace pirvs {

enum class CommandKind : uint8_t {
  kStop,          // in order: what was sensed is tracked and mapped to its end
  kReset,         // forget the map and start anew; W begins where the next start does
  kSetParameter,  // text: group.name, value
  // The present pose is p_WB with heading yaw_rad: W moves, the tilt stays. value > 0, with a
  // loaded map that was not recognised yet: a hint of that sigma in m, the map stays where it is.
  kSetPose,
  kSaveMap,         // text: name of the file
  kLoadMap,         // text: name of the file; what runs is given up, a start looks for its place
  kStartRecording,  // by bsp/api/storage.h
  kStopRecording,
  // text: name of a place of the map. value 1: it is at p_WB with heading yaw_rad; 0: here.
  kSetNode,
  kGetNode,     // text: name; its pose is in the answer
  kRemoveNode,  // text: name
  kCount
};
const char* name(CommandKind kind);

struct Command {
  static constexpr int kTextMax = 64;
  CommandKind kind = CommandKind::kStop;
  uint32_t ticket = 0;  // given by Inbox::push()
  float value = 0;
  double yaw_rad = 0;
  Vec3 p_WB = Vec3::Zero();
  char text[kTextMax] = "";
};

struct Answer {
  uint32_t ticket = 0;
  CommandKind kind = CommandKind::kStop;
  Status status = Status::kOk;
  SE3 T_WN;  // kGetNode
};

}  // namespace pirvs
