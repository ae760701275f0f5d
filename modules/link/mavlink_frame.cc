#include "modules/link/mavlink_frame.h"

#include <algorithm>
#include <cstring>

#include "modules/link/mavlink_messages.h"

namespace pirvs::mavlink {
namespace {

constexpr uint8_t kStart = 0xFD, kStartVersion1 = 0xFE;
constexpr uint8_t kSigned = 1;
constexpr size_t kHeaderBytesVersion1 = 6;
// No dialect in use numbers its messages higher: beyond it stands noise.
constexpr uint32_t kIdMax = 0xFFFF;

// CRC-16/MCRF4XX: X.25's polynomial, reflected, without its last inversion.
class Checksum {
 public:
  void add(uint8_t byte) {
    uint8_t x = static_cast<uint8_t>(byte ^ (value_ & 0xFF));
    x = static_cast<uint8_t>(x ^ x << 4);
    value_ = static_cast<uint16_t>(value_ >> 8 ^ x << 8 ^ x << 3 ^ x >> 4);
  }
  void add(const uint8_t* bytes, size_t size) {
    for (size_t i = 0; i < size; ++i) add(bytes[i]);
  }
  uint16_t value() const { return value_; }

 private:
  uint16_t value_ = 0xFFFF;
};

// Of what stands between STX and the checksum.
uint16_t checksum(const uint8_t* frame, size_t end, uint8_t extra) {
  Checksum sum;
  sum.add(frame + 1, end - 1);
  sum.add(extra);
  return sum.value();
}

uint16_t checksum_at(const uint8_t* bytes) {
  return static_cast<uint16_t>(bytes[0] | bytes[1] << 8);
}

uint32_t id_of(const uint8_t* frame) {
  return frame[7] | uint32_t{frame[8]} << 8 | uint32_t{frame[9]} << 16;
}

}  // namespace

size_t FrameParser::push(const uint8_t* bytes, size_t size) {
  if (begin_ > 0) std::memmove(bytes_, bytes_ + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const size_t taken = std::min(size, sizeof bytes_ - end_);
  if (taken > 0) std::memcpy(bytes_ + end_, bytes, taken);
  end_ += taken;
  return taken;
}

FrameParser::Found FrameParser::look_v2(const uint8_t* bytes, size_t left, size_t& size) {
  if (left > 2 && (bytes[2] & ~kSigned) != 0) {
    ++counters_.flags_refused;
    return Found::kNothing;
  }
  if (left < kHeaderBytes) return Found::kMore;
  if (id_of(bytes) > kIdMax) return Found::kNothing;
  const size_t end = kHeaderBytes + bytes[1];
  size = end + kChecksumBytes + ((bytes[2] & kSigned) != 0 ? kSignatureBytes : 0);
  if (left < size) return Found::kMore;
  const MessageKind* const kind = find_kind(id_of(bytes));
  if (kind == nullptr) {  // its checksum cannot be known: it is one where another one follows
    if (left == size) return Found::kMore;
    if (bytes[size] != kStart && bytes[size] != kStartVersion1) return Found::kNothing;
    ++counters_.unknown;
    return Found::kOther;
  }
  if (checksum(bytes, end, kind->crc_extra) == checksum_at(bytes + end)) return Found::kFrame;
  ++counters_.bad_checksum;
  return Found::kNothing;
}

// Only what its checksum proves to be one: its start alone is a byte like any other.
FrameParser::Found FrameParser::look_v1(const uint8_t* bytes, size_t left, size_t& size) {
  if (left < kHeaderBytesVersion1) return Found::kMore;
  const MessageKind* const kind = find_kind(bytes[5]);
  if (kind == nullptr || bytes[1] > kind->size) return Found::kNothing;
  const size_t end = kHeaderBytesVersion1 + bytes[1];
  size = end + kChecksumBytes;
  if (left < size) return Found::kMore;
  if (checksum(bytes, end, kind->crc_extra) != checksum_at(bytes + end)) return Found::kNothing;
  ++counters_.version_1;
  return Found::kOther;
}

bool FrameParser::next(Frame& out) {
  while (begin_ < end_) {
    const uint8_t* const bytes = bytes_ + begin_;
    const size_t left = end_ - begin_;
    size_t size = 0;
    Found found = Found::kNothing;
    if (bytes[0] == kStart) found = look_v2(bytes, left, size);
    if (bytes[0] == kStartVersion1) found = look_v1(bytes, left, size);
    if (found == Found::kMore) return false;
    if (found == Found::kNothing) {
      ++counters_.bytes_skipped;
      size = 1;
    }
    begin_ += size;
    if (found != Found::kFrame) continue;
    out = Frame{};
    out.id = id_of(bytes);
    out.size = bytes[1];
    out.is_signed = (bytes[2] & kSigned) != 0;
    out.sequence = bytes[4];
    out.system = bytes[5];
    out.component = bytes[6];
    std::memcpy(out.payload, bytes + kHeaderBytes, out.size);
    ++counters_.frames;
    counters_.signature_ignored += out.is_signed;
    return true;
  }
  return false;
}

size_t write_frame(const MessageKind& kind, const uint8_t* payload, Sender& sender,
                   uint8_t (&out)[kFrameMax]) {
  size_t size = kind.size;
  while (size > 1 && payload[size - 1] == 0) --size;
  out[0] = kStart;
  out[1] = static_cast<uint8_t>(size);
  out[2] = out[3] = 0;
  out[4] = sender.sequence++;
  out[5] = sender.system;
  out[6] = sender.component;
  for (size_t i = 0; i < 3; ++i) out[7 + i] = static_cast<uint8_t>(kind.id >> 8 * i);
  std::memcpy(out + kHeaderBytes, payload, size);
  const size_t end = kHeaderBytes + size;
  const uint16_t sum = checksum(out, end, kind.crc_extra);
  out[end] = static_cast<uint8_t>(sum & 0xFF);
  out[end + 1] = static_cast<uint8_t>(sum >> 8);
  return end + kChecksumBytes;
}

}  // namespace pirvs::mavlink
