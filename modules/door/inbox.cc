#include "modules/door/inbox.h"

namespace pirvs {
namespace {

class Lock {
 public:
  explicit Lock(std::atomic_flag& flag) : flag_(flag) {
    while (flag_.test_and_set(std::memory_order_acquire)) {
    }
  }
  ~Lock() { flag_.clear(std::memory_order_release); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  std::atomic_flag& flag_;
};

}  // namespace

Result<uint32_t> Inbox::push(const Command& command) {
  const Lock lock(locked_);
  Arrival* const slot = waiting_.begin_push();
  if (slot == nullptr) return Status::kFull;
  *slot = arrival_of(command);
  slot->command.ticket = ++tickets_;
  waiting_.end_push();
  return tickets_;
}

Status Inbox::push(const Arrival& arrival) {
  const Lock lock(locked_);
  return waiting_.push(arrival) ? Status::kOk : Status::kFull;
}

bool Inbox::pop(Arrival& out) {
  const Arrival* const oldest = waiting_.front();
  if (oldest == nullptr) return false;
  out = *oldest;
  waiting_.pop();
  return true;
}

}  // namespace pirvs
