// Fixes from the bytes of a u-blox receiver: UBX-NAV-PVT, refined by UBX-NAV-COV where it is sent.
// In      take(): one byte after the other, whatever they are.
// Out     True when a fix is complete: at its NAV-PVT, or at the NAV-COV behind it once the
//         receiver has shown that it sends them.
// Units   as in receiver_fix.h. hAcc and sAcc, which are of a plane, become sigmas of one axis.
// Errors  Counted: bytes that belong to no valid frame, frames whose checksum is wrong; after
//         either, the search for a frame goes on at the next byte. A fix whose NAV-COV was lost is
//         overtaken by the next one.
// Cost    ~2 ns a byte; in garbage made to deceive kFrameMax times that at most. 4 kB.
// Source  u-blox F9 HPG 1.32 interface description: frame 3.2, NAV-PVT 3.15.14, NAV-COV 3.15.1.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/counter.h"
#include "modules/gnss/receiver_fix.h"

namespace pirvs {

struct UbxCounters {
  Counter frames, pvt, cov;  // valid ones: all, and those that are read
  Counter bytes_outside;     // of no valid frame
  Counter checksums_wrong;
  Counter fixes_overtaken;
};
inline constexpr CounterRow<UbxCounters> kUbxCounters[] = {
    {"ubx_frames", &UbxCounters::frames},
    {"ubx_pvt", &UbxCounters::pvt},
    {"ubx_cov", &UbxCounters::cov},
    {"ubx_bytes_outside", &UbxCounters::bytes_outside},
    {"ubx_checksums_wrong", &UbxCounters::checksums_wrong},
    {"ubx_fixes_overtaken", &UbxCounters::fixes_overtaken},
};
static_assert(every_counter_is_in(kUbxCounters));

class UbxReader {
 public:
  static constexpr size_t kFrameMax = 4096;  // raw measurements of 120 signals

  [[nodiscard]] bool take(uint8_t byte, ReceiverFix& out);
  // At the end, until false: what garbage has held up, and a fix that waits for its covariance.
  [[nodiscard]] bool flush(ReceiverFix& out);
  const UbxCounters& counters() const { return counters_; }

 private:
  enum class Frame : uint8_t { kNone, kIncomplete, kValid };
  Frame look();
  bool next(ReceiverFix& out);
  bool read(ReceiverFix& out);
  bool read_pvt(const uint8_t* payload, ReceiverFix& out);
  bool read_cov(const uint8_t* payload, ReceiverFix& out);
  void drop(size_t count);

  uint8_t bytes_[kFrameMax];
  size_t size_ = 0;
  ReceiverFix waiting_;
  bool is_waiting_ = false, cov_follows_ = false;
  uint32_t waiting_tow_ms_ = 0, last_tow_ms_ = 0;
  bool has_last_ = false;
  UbxCounters counters_;
};

}  // namespace pirvs
