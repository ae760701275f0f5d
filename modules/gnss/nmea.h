// Fixes from the text of a receiver: NMEA 0183, GGA (place), RMC (date, speed, course), VTG (speed,
// course) and GST (sigmas), of any talker.
// In      take(): one character after the other, whatever they are.
// Out     True when a fix is complete: the sentences of one time of day are one fix. It is told at
//         the sentence that came last the time before, the first one when another time begins.
// Units   as in receiver_fix.h. Height above the ellipsoid is GGA's altitude and its geoid
//         separation; without the latter the fix is 2d. The vertical speed is not measured: NaN.
// Errors  Counted by name: see NmeaCounters. A sentence that is wrong says nothing.
// Cost    ~3 ns a character, ~1 us a sentence. 0.3 kB.
// Source  NMEA 0183 4.10; u-blox F9 HPG 1.32 interface description, 2.7; Trimble, "NMEA-0183
//         message: GST".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/counter.h"
#include "modules/gnss/receiver_fix.h"

namespace pirvs {

struct NmeaCounters {
  Counter sentences;      // with a right checksum: all
  Counter bytes_outside;  // of no such sentence
  Counter checksums_wrong;
  Counter fields_wrong;  // of GGA, RMC, VTG or GST: the sentence says nothing
  Counter too_long;
};
inline constexpr CounterRow<NmeaCounters> kNmeaCounters[] = {
    {"nmea_sentences", &NmeaCounters::sentences},
    {"nmea_bytes_outside", &NmeaCounters::bytes_outside},
    {"nmea_checksums_wrong", &NmeaCounters::checksums_wrong},
    {"nmea_fields_wrong", &NmeaCounters::fields_wrong},
    {"nmea_too_long", &NmeaCounters::too_long},
};
static_assert(every_counter_is_in(kNmeaCounters));

class NmeaReader {
 public:
  [[nodiscard]] bool take(uint8_t byte, ReceiverFix& out);
  // The fix whose sentences have come so far.
  [[nodiscard]] bool flush(ReceiverFix& out);
  const NmeaCounters& counters() const { return counters_; }

 private:
  static constexpr size_t kSentenceMax = 120;  // the norm has 82, receivers of centimetres more
  static constexpr size_t kFieldsMax = 24;
  enum Kind : uint8_t { kGga, kRmc, kVtg, kGst, kKinds };

  // What the sentences of one time have said.
  struct Epoch {
    bool any = false, told = false;
    bool has_time = false;
    int64_t time_of_day_ns = 0;
    uint8_t kinds = 0;  // by bit
    GnssFix fix;
    double speed_m_s = 0, course_deg = 0;
  };

  bool take_byte(uint8_t byte, ReceiverFix& out);
  bool read_sentence(ReceiverFix& out);
  bool read_fields(Kind kind, const std::string_view* fields, size_t count, Epoch& out);
  bool read_gga(const std::string_view* fields, Epoch& out);
  bool read_rmc(const std::string_view* fields, Epoch& out);
  bool read_vtg(const std::string_view* fields, Epoch& out);
  bool read_gst(const std::string_view* fields, Epoch& out);
  void tell(ReceiverFix& out);

  char text_[kSentenceMax];
  size_t size_ = 0;
  bool inside_ = false;
  bool is_due_ = false;  // the epoch at hand: where one sentence is all there is of each
  Epoch epoch_;
  Kind last_kind_ = kKinds;     // that came in this epoch
  Kind closing_kind_ = kKinds;  // that closed the epoch before
  int64_t days_ = 0;            // since 1970, by RMC
  int64_t days_time_ns_ = 0;    // and the time of day then
  bool has_date_ = false;
  NmeaCounters counters_;
};

}  // namespace pirvs
