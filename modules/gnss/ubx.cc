#include "modules/gnss/ubx.h"

#include <cmath>
#include <cstring>

namespace pirvs {
namespace {

constexpr uint8_t kSync0 = 0xb5, kSync1 = 0x62;
constexpr size_t kHead = 6, kTail = 2;
constexpr uint8_t kNav = 0x01, kPvt = 0x07, kCov = 0x36;
constexpr size_t kPvtSize = 92, kCovSize = 64;
constexpr double kSqrt2 = 1.4142135623730951;
constexpr TimeNs kSecond_ns = 1'000'000'000;

uint32_t u32(const uint8_t* p) {
  return uint32_t{p[0]} | uint32_t{p[1]} << 8 | uint32_t{p[2]} << 16 | uint32_t{p[3]} << 24;
}
int32_t i32(const uint8_t* p) { return static_cast<int32_t>(u32(p)); }
double f32(const uint8_t* p) {
  const uint32_t bits = u32(p);
  float out;
  std::memcpy(&out, &bits, sizeof out);
  return static_cast<double>(out);
}

bool checksum_fits(const uint8_t* frame, size_t size) {
  uint8_t a = 0, b = 0;
  for (size_t i = 2; i < size - kTail; ++i) {
    a = static_cast<uint8_t>(a + frame[i]);
    b = static_cast<uint8_t>(b + a);
  }
  return frame[size - 2] == a && frame[size - 1] == b;
}

GnssFixType type_of(uint8_t fix_type, uint8_t flags) {
  constexpr uint8_t k2d = 2, k3d = 3, kWithDeadReckoning = 4;
  const bool good = (flags & 1) != 0;
  const int carrier = flags >> 6;
  if (!good) return GnssFixType::kNone;
  if (fix_type == k2d) return GnssFixType::k2d;
  if (fix_type != k3d && fix_type != kWithDeadReckoning) return GnssFixType::kNone;
  return carrier == 2 ? GnssFixType::kFixed : carrier == 1 ? GnssFixType::kFloat : GnssFixType::k3d;
}

}  // namespace

UbxReader::Frame UbxReader::look() {
  if (size_ >= 1 && bytes_[0] != kSync0) return Frame::kNone;
  if (size_ >= 2 && bytes_[1] != kSync1) return Frame::kNone;
  if (size_ < kHead) return Frame::kIncomplete;
  const size_t size = kHead + bytes_[4] + (size_t{bytes_[5]} << 8) + kTail;
  if (size > kFrameMax) return Frame::kNone;
  if (size_ < size) return Frame::kIncomplete;
  if (checksum_fits(bytes_, size)) return Frame::kValid;
  ++counters_.checksums_wrong;
  return Frame::kNone;
}

void UbxReader::drop(size_t count) {
  size_ -= count;
  std::memmove(bytes_, bytes_ + count, size_);
}

bool UbxReader::take(uint8_t byte, ReceiverFix& out) {
  bytes_[size_++] = byte;
  return next(out);
}

// One fix at a time: behind garbage that looked like a long frame there may be several, which the
// next calls find.
bool UbxReader::next(ReceiverFix& out) {
  while (size_ > 0) {
    const Frame frame = look();
    if (frame == Frame::kIncomplete) break;
    if (frame == Frame::kValid) {
      ++counters_.frames;
      const bool fix = read(out);
      drop(kHead + bytes_[4] + (size_t{bytes_[5]} << 8) + kTail);
      if (fix) return true;
      continue;
    }
    // To the next byte that may begin a frame.
    size_t begin = 1;
    while (begin < size_ && bytes_[begin] != kSync0) ++begin;
    counters_.bytes_outside += static_cast<uint32_t>(begin);
    drop(begin);
  }
  return false;
}

bool UbxReader::read(ReceiverFix& out) {
  const size_t size = bytes_[4] + (size_t{bytes_[5]} << 8);
  if (bytes_[2] != kNav) return false;
  if (bytes_[3] == kPvt && size == kPvtSize) return read_pvt(bytes_ + kHead, out);
  if (bytes_[3] == kCov && size == kCovSize) return read_cov(bytes_ + kHead, out);
  return false;
}

bool UbxReader::read_pvt(const uint8_t* p, ReceiverFix& out) {
  ++counters_.pvt;
  if (is_waiting_) {
    ++counters_.fixes_overtaken;
    cov_follows_ = false;
  }
  ReceiverFix now;
  constexpr double kDeg = 1e-7, kMilli = 1e-3;
  now.fix.type = type_of(p[20], p[21]);
  now.fix.longitude_deg = kDeg * i32(p + 24);
  now.fix.latitude_deg = kDeg * i32(p + 28);
  now.fix.height_m = kMilli * i32(p + 32);
  now.fix.sigma_horizontal_m = kMilli * u32(p + 40) / kSqrt2;
  now.fix.sigma_vertical_m = kMilli * u32(p + 44);
  now.fix.v_ned = kMilli * Vec3(i32(p + 48), i32(p + 52), i32(p + 56));
  now.fix.sigma_velocity_m_s = kMilli * u32(p + 68) / kSqrt2;
  now.fix.has_velocity = now.fix.type != GnssFixType::kNone;
  constexpr uint8_t kDateAndTime = 3;
  const int year = p[4] | p[5] << 8, month = p[6], day = p[7], hour = p[8], minute = p[9],
            second = p[10];
  const bool possible = year >= 1970 && year < 2200 && month >= 1 && month <= 12 && day >= 1 &&
                        day <= 31 && hour < 24 && minute < 60 && second <= 60;
  now.has_time = (p[11] & kDateAndTime) == kDateAndTime && possible;
  if (now.has_time) {
    const int64_t days = days_since_1970(year, month, day);
    now.t_utc = (days * 86400 + hour * 3600 + minute * 60 + second) * kSecond_ns + i32(p + 16);
  }
  last_tow_ms_ = u32(p);
  has_last_ = true;
  is_waiting_ = cov_follows_;
  if (is_waiting_) {
    waiting_ = now;
    waiting_tow_ms_ = last_tow_ms_;
    return false;
  }
  out = now;
  return true;
}

bool UbxReader::read_cov(const uint8_t* p, ReceiverFix& out) {
  ++counters_.cov;
  const bool same = has_last_ && u32(p) == last_tow_ms_;
  if (same) cov_follows_ = true;
  if (!same || !is_waiting_ || waiting_tow_ms_ != last_tow_ms_) return false;
  is_waiting_ = false;
  out = waiting_;
  const bool place_valid = p[5] == 1, velocity_valid = p[6] == 1;
  const double nn = f32(p + 16), ee = f32(p + 28), dd = f32(p + 36);
  if (place_valid && nn >= 0 && ee >= 0 && dd >= 0) {
    out.fix.sigma_horizontal_m = std::sqrt((nn + ee) / 2);
    out.fix.sigma_vertical_m = std::sqrt(dd);
  }
  const double vnn = f32(p + 40), vee = f32(p + 52), vdd = f32(p + 60);
  if (velocity_valid && vnn >= 0 && vee >= 0 && vdd >= 0) {
    out.fix.sigma_velocity_m_s = std::sqrt((vnn + vee + vdd) / 3);
  }
  return true;
}

bool UbxReader::flush(ReceiverFix& out) {
  if (next(out)) return true;
  if (!is_waiting_) return false;
  is_waiting_ = false;
  out = waiting_;
  return true;
}

}  // namespace pirvs
