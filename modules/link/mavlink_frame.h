// Frames of MAVLink 2: bytes of a line or of datagrams to frames, and back.
// In      FrameParser::push(): bytes as they come, in pieces of any size; write_frame(): a payload.
// Out     FrameParser::next(): the oldest whole frame whose checksum is right. A payload shorter
//         than its message has zeros for what its sender cut off; one longer, of a newer dialect,
//         is left to decode(), which reads what it knows.
// Errors  Counted, by what came instead of a frame of ours: see ParserCounters. After a byte that
//         begins none, or a checksum that is wrong, the search goes on at the very next byte: a
//         false start costs no frame behind it, unless it looks like a message that is not known
//         here, whose checksum nobody can check, and another start stands where that would end.
// Cost    ~2 ns a byte; no heap, 0.6 kB.
// Source  MAVLink 2, "Serialization": STX 0xFD, size, incompatible flags, compatible flags,
//         sequence, system, component, id (3 bytes), payload, CRC-16/MCRF4XX of all but STX and
//         then of the message's CRC_EXTRA; signed frames (flag 1) end with 13 bytes more.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/counter.h"

namespace pirvs::mavlink {

inline constexpr size_t kPayloadMax = 255;
inline constexpr size_t kHeaderBytes = 10, kChecksumBytes = 2, kSignatureBytes = 13;
inline constexpr size_t kFrameMax = kHeaderBytes + kPayloadMax + kChecksumBytes + kSignatureBytes;

// What both ends must know of a message besides its fields.
struct MessageKind {
  uint32_t id = 0;
  uint8_t crc_extra = 0;
  uint8_t size = 0;  // with extensions, before zeros are cut
};

struct Frame {
  uint32_t id = 0;
  uint8_t system = 0, component = 0, sequence = 0;
  uint8_t size = 0;  // as it was sent
  bool is_signed = false;
  uint8_t payload[kPayloadMax] = {};
};

struct ParserCounters {
  Counter frames, unknown, version_1, signature_ignored, flags_refused, bad_checksum, bytes_skipped;
};
inline constexpr CounterRow<ParserCounters> kParserRows[] = {
    {"frames", &ParserCounters::frames},        // whole, of a message that is known here
    {"unknown", &ParserCounters::unknown},      // of other messages, skipped
    {"version_1", &ParserCounters::version_1},  // frames of MAVLink 1, skipped
    // Taken as if it had no signature: there is no key to check it with.
    {"signature_ignored", &ParserCounters::signature_ignored},
    {"flags_refused", &ParserCounters::flags_refused},  // incompatible flags besides signing
    {"bad_checksum", &ParserCounters::bad_checksum},
    {"bytes_skipped", &ParserCounters::bytes_skipped},  // that begin no frame
};
static_assert(every_counter_is_in(kParserRows));

class FrameParser {
 public:
  // How many bytes there was room for; all, after next() has said false, up to kFrameMax.
  size_t push(const uint8_t* bytes, size_t size);
  [[nodiscard]] bool next(Frame& out);
  void clear() { begin_ = end_ = 0; }
  const ParserCounters& counters() const { return counters_; }

 private:
  enum class Found : uint8_t { kMore, kNothing, kOther, kFrame };

  Found look_v2(const uint8_t* bytes, size_t left, size_t& size);
  Found look_v1(const uint8_t* bytes, size_t left, size_t& size);

  uint8_t bytes_[2 * kFrameMax];
  size_t begin_ = 0, end_ = 0;
  ParserCounters counters_;
};

struct Sender {
  uint8_t system = 1, component = 0, sequence = 0;
};

// `payload` has kind.size bytes; zeros at its end are cut. The frame's size; sequence goes on.
size_t write_frame(const MessageKind& kind, const uint8_t* payload, Sender& sender,
                   uint8_t (&out)[kFrameMax]);

}  // namespace pirvs::mavlink
