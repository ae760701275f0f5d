// Outcome of a call that the world can make fail (a fault), and a value that may be missing.
// In      A Status, or a value, or an expression that yields a Status (PIRVS_TRY).
// Out     kOk or the first thing that went wrong; name() gives its text for logs.
// Errors  Result::value() on a failure is a bug and asserts.
// Cost    One byte; Result<T> is T plus one byte, by value, no heap.
// Source  STYLE principle 7; Pigweed pw_status, pw_result.
#pragma once

#include <cstdint>

#include "core/base/assert.h"

namespace pirvs {

enum class [[nodiscard]] Status : uint8_t{
    kOk,
    kTimeout,   // the device did not answer in time
    kBusFault,  // the device or file answered with an error
    kFull,      // no room: pool, ring, disk
    kEmpty,     // nothing there now; ask again later
    kStale,     // too old, or the stream has ended
    kBadData,   // present but not usable
    kNotFound,  // no such name or object
};

constexpr const char* name(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTimeout:
      return "timeout";
    case Status::kBusFault:
      return "bus fault";
    case Status::kFull:
      return "full";
    case Status::kEmpty:
      return "empty";
    case Status::kStale:
      return "stale";
    case Status::kBadData:
      return "bad data";
    case Status::kNotFound:
      return "not found";
  }
  return "unknown status";
}

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(value), status_(Status::kOk) {}
  Result(Status status) : status_(status) { PIRVS_ASSERT(status != Status::kOk); }

  bool ok() const { return status_ == Status::kOk; }
  Status status() const { return status_; }
  const T& value() const {
    PIRVS_ASSERT(ok());
    return value_;
  }

 private:
  T value_{};
  Status status_;
};

}  // namespace pirvs

// Returns the status of `expr` to the caller unless it is kOk.
#define PIRVS_TRY(expr)                                                                    \
  do {                                                                                     \
    if (const ::pirvs::Status pirvs_status = (expr); pirvs_status != ::pirvs::Status::kOk) \
      return pirvs_status;                                                                 \
  } while (0)
