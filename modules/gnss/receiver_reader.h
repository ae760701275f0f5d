// Fixes from the bytes of a receiver that speaks UBX, NMEA or both at once.
// In      take(): one byte after the other, whatever they are.
// Out     True when a fix is complete. UBX says more than NMEA, so while its fixes come those of
//         NMEA, which are the same ones again, are left out.
// Units   as in receiver_fix.h.
// Errors  Counted by both readers (ubx.h, nmea.h), each of which takes the other's bytes for noise.
// Cost    ~5 ns a byte. 5 kB.
// Source  u-blox F9 HPG 1.32 interface description, 3.1: a port carries several protocols at once.
#pragma once

#include "modules/gnss/nmea.h"
#include "modules/gnss/ubx.h"

namespace pirvs {

class ReceiverReader {
 public:
  [[nodiscard]] bool take(uint8_t byte, ReceiverFix& out) {
    // Both take each byte, whatever the other one makes of it.
    ReceiverFix nmea;
    const bool by_nmea = nmea_.take(byte, nmea);
    if (ubx_.take(byte, out)) {
      nmea_since_ubx_ = 0;
      return true;
    }
    if (!by_nmea || nmea_since_ubx_ < kUbxGone) {
      if (by_nmea) ++nmea_since_ubx_;
      return false;
    }
    out = nmea;
    return true;
  }

  const UbxCounters& ubx() const { return ubx_.counters(); }
  const NmeaCounters& nmea() const { return nmea_.counters(); }

 private:
  // So many fixes of NMEA without one of UBX: the receiver does not send it, or no longer.
  static constexpr int kUbxGone = 3;

  UbxReader ubx_;
  NmeaReader nmea_;
  int nmea_since_ubx_ = kUbxGone;
};

}  // namespace pirvs
