#include "modules/door/command.h"

#include <iterator>

namespace pirvs {

const char* name(CommandKind kind) {
  static constexpr const char* kNames[] = {"stop",     "reset",         "set parameter",
                                           "set pose", "save map",      "load map",
                                           "record",   "stop recording"};
  static_assert(std::size(kNames) == static_cast<size_t>(CommandKind::kCount));
  return kNames[static_cast<size_t>(kind)];
}

Result<uint32_t> CommandQueue::push(const Command& command) {
  while (!lock()) {
  }
  Command* const slot = waiting_.append();
  if (slot == nullptr) {
    unlock();
    return Status::kFull;
  }
  *slot = command;
  slot->ticket = ++tickets_;
  const uint32_t ticket = slot->ticket;
  waiting_count_.store(static_cast<uint32_t>(waiting_.size()), std::memory_order_release);
  unlock();
  return ticket;
}

bool CommandQueue::pop(Command& out) {
  if (waiting_count_.load(std::memory_order_acquire) == 0 || !lock()) return false;
  out = waiting_[0];
  for (size_t i = 1; i < waiting_.size(); ++i) waiting_[i - 1] = waiting_[i];
  waiting_.pop_back();
  waiting_count_.store(static_cast<uint32_t>(waiting_.size()), std::memory_order_release);
  unlock();
  return true;
}

}  // namespace pirvs
