// What a user, a robot's link or a pin may ask of the running stack, and the answer. Commands come
// in by the door, so that a recording holds them and a replay obeys them again.
// Frames  W, B as everywhere.
// Units   m, rad.
// Errors  push: kFull, the command was not taken. The answer's status is the outcome:
//         kOk done; kNotFound no such name; kBadData a value that is not allowed; kFull, kBusFault
//         the storage refuses; kStale not possible in this state.
// Cost    ~200 bytes a command.
// Source  own.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/status.h"
#include "core/math/types.h"
#include "core/store/fixed_vector.h"

namespace pirvs {

enum class CommandKind : uint8_t {
  kStop,            // in order: what was sensed is tracked and mapped to its end
  kReset,           // forget the map and start anew; W begins where the next start does
  kSetParameter,    // text: group.name, value
  kSetPose,         // the present pose is p_WB with heading yaw_rad: W moves, the tilt stays
  kSaveMap,         // text: name of the file
  kLoadMap,         // text: name of the file; what runs is given up, a start looks for its place
  kStartRecording,  // by bsp/api/storage.h
  kStopRecording,
  kCount
};
const char* name(CommandKind kind);

struct Command {
  static constexpr int kTextMax = 64;
  CommandKind kind = CommandKind::kStop;
  uint32_t ticket = 0;  // given by push()
  float value = 0;
  double yaw_rad = 0;
  Vec3 p_WB = Vec3::Zero();
  char text[kTextMax] = "";
};

struct Answer {
  uint32_t ticket = 0;
  CommandKind kind = CommandKind::kStop;
  Status status = Status::kOk;
};

// From any core to the door's. Senders hold a lock for the time of one copy; the door never waits.
class CommandQueue {
 public:
  Result<uint32_t> push(const Command& command);  // any core; the ticket that the answer names
  bool pop(Command& out);                         // the door's core

 private:
  static constexpr size_t kWaitingMax = 16;
  bool lock() { return !locked_.test_and_set(std::memory_order_acquire); }
  void unlock() { locked_.clear(std::memory_order_release); }

  std::atomic_flag locked_ = ATOMIC_FLAG_INIT;
  FixedVector<Command, kWaitingMax> waiting_;
  std::atomic<uint32_t> waiting_count_{0};
  uint32_t tickets_ = 0;
};

}  // namespace pirvs
