#include "modules/gnss/nmea.h"

#include <cmath>

#include "core/base/number.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000, kDay_ns = 86400 * kSecond_ns;
constexpr double kKnot_m_s = 1852.0 / 3600, kKmh_m_s = 1 / 3.6;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

int hex_digit(char c) {
  if (is_digit(c)) return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

std::string_view part(std::string_view text, size_t from, size_t count) {
  return {text.data() + from, count};  // substr() may throw: not without an OS
}

bool two_digits(std::string_view text, size_t at, int& out) {
  if (text.size() < at + 2 || !is_digit(text[at]) || !is_digit(text[at + 1])) return false;
  out = 10 * (text[at] - '0') + text[at + 1] - '0';
  return true;
}

// hhmmss or hhmmss.sss
bool read_time(std::string_view text, int64_t& out) {
  int hour = 0, minute = 0, second = 0;
  if (!two_digits(text, 0, hour) || !two_digits(text, 2, minute) || !two_digits(text, 4, second)) {
    return false;
  }
  if (hour > 23 || minute > 59 || second > 60) return false;
  int64_t fraction = 0, weight = kSecond_ns / 10;
  for (size_t i = 6; i < text.size(); ++i, weight /= 10) {
    if (i == 6 && text[i] == '.') {
      weight *= 10;
      continue;
    }
    if (i == 6 || !is_digit(text[i])) return false;
    fraction += weight * (text[i] - '0');
  }
  out = (hour * 3600 + minute * 60 + second) * kSecond_ns + fraction;
  return true;
}

// [d]ddmm.mmmm and a letter
bool read_angle(std::string_view text, std::string_view letter, const char* letters, double max_deg,
                double& out) {
  const size_t point = text.find('.');
  const size_t whole = point == std::string_view::npos ? text.size() : point;
  if (whole < 3 || letter.size() != 1) return false;
  double degrees = 0, minutes = 0;
  if (!read_number(part(text, 0, whole - 2), degrees)) return false;
  if (!is_digit(text[0]) || !is_digit(text[whole - 2])) return false;
  if (!read_number(part(text, whole - 2, text.size() - whole + 2), minutes)) return false;
  if (minutes >= 60 || degrees + minutes / 60 > max_deg) return false;
  if (letter[0] != letters[0] && letter[0] != letters[1]) return false;
  out = (letter[0] == letters[0] ? 1 : -1) * (degrees + minutes / 60);
  return true;
}

bool is_finite_number(std::string_view text, double& out) {
  return read_number(text, out) && std::isfinite(out);
}

constexpr uint8_t bit(int kind) { return static_cast<uint8_t>(1u << kind); }

}  // namespace

bool NmeaReader::take(uint8_t byte, ReceiverFix& out) {
  if (take_byte(byte, out)) return true;
  if (!is_due_) return false;
  is_due_ = false;
  return flush(out);
}

bool NmeaReader::take_byte(uint8_t byte, ReceiverFix& out) {
  const char c = static_cast<char>(byte);
  if (c == '$') {
    counters_.bytes_outside += static_cast<uint32_t>(inside_ ? size_ : 0);
    inside_ = true;
    text_[0] = c;
    size_ = 1;
    return false;
  }
  if (!inside_) {
    ++counters_.bytes_outside;
    return false;
  }
  if (c == '\r' || c == '\n') {
    inside_ = false;
    return read_sentence(out);
  }
  if (size_ == kSentenceMax || byte < 0x20 || byte > 0x7e) {
    if (size_ == kSentenceMax) ++counters_.too_long;
    counters_.bytes_outside += static_cast<uint32_t>(size_ + 1);
    inside_ = false;
    return false;
  }
  text_[size_++] = c;
  return false;
}

// $TTKKK,field,...*HH: talker, kind, checksum of all between $ and *.
bool NmeaReader::read_sentence(ReceiverFix& out) {
  constexpr size_t kTail = 3, kHead = 6;
  const auto refuse = [this](Counter& why) {
    ++why;
    counters_.bytes_outside += static_cast<uint32_t>(size_);
    return false;
  };
  if (size_ < kHead + kTail || text_[size_ - kTail] != '*')
    return refuse(counters_.checksums_wrong);
  uint8_t sum = 0;
  for (size_t i = 1; i < size_ - kTail; ++i) sum = static_cast<uint8_t>(sum ^ text_[i]);
  if (hex_digit(text_[size_ - 2]) != sum >> 4 || hex_digit(text_[size_ - 1]) != (sum & 15)) {
    return refuse(counters_.checksums_wrong);
  }
  ++counters_.sentences;
  constexpr const char* kNames[kKinds] = {"GGA", "RMC", "VTG", "GST"};
  const std::string_view name(text_ + 3, 3);
  int kind = 0;
  while (kind < kKinds && name != kNames[kind]) ++kind;
  if (kind == kKinds) return false;
  std::string_view fields[kFieldsMax];
  size_t count = 0, begin = 1;
  for (size_t i = 1; i <= size_ - kTail && count < kFieldsMax; ++i) {
    if (text_[i] != ',' && i != size_ - kTail) continue;
    fields[count++] = std::string_view(text_ + begin, i - begin);
    begin = i + 1;
  }
  // The times of two epochs are told apart before anything of the new one is written down.
  Epoch next = epoch_;
  if (kind != kVtg && count > 1) {
    int64_t time = 0;
    if (!fields[1].empty() && !read_time(fields[1], time)) {
      ++counters_.fields_wrong;
      return false;
    }
    const bool has_time = !fields[1].empty();
    if (!epoch_.any || has_time != epoch_.has_time || time != epoch_.time_of_day_ns) {
      next = Epoch{};
      next.has_time = has_time;
      next.time_of_day_ns = time;
    }
  }
  if (!read_fields(static_cast<Kind>(kind), fields, count, next)) {
    ++counters_.fields_wrong;
    return false;
  }
  bool any = false;
  if (!next.any) {  // another epoch begins
    if (epoch_.any) closing_kind_ = last_kind_;
    any = flush(out);
    out.overdue = any;
  }
  next.any = true;
  next.kinds = static_cast<uint8_t>(next.kinds | bit(kind));
  epoch_ = next;
  last_kind_ = static_cast<Kind>(kind);
  const bool closed = !epoch_.told && kind == closing_kind_;
  is_due_ = closed && any;  // one at a time: this one at the next byte, the end of its line
  return any || (closed && flush(out));
}

bool NmeaReader::read_fields(Kind kind, const std::string_view* fields, size_t count, Epoch& out) {
  constexpr size_t kNeeded[kKinds] = {12, 10, 8, 9};
  if (count < kNeeded[kind]) return false;
  switch (kind) {
    case kGga:
      return read_gga(fields, out);
    case kRmc:
      return read_rmc(fields, out);
    case kVtg:
      return read_vtg(fields, out);
    default:
      return read_gst(fields, out);
  }
}

// time, latitude, N, longitude, E, quality, satellites, hdop, altitude, M, separation, M, ...
bool NmeaReader::read_gga(const std::string_view* f, Epoch& out) {
  constexpr GnssFixType kTypes[] = {GnssFixType::kNone, GnssFixType::k3d,    GnssFixType::k3d,
                                    GnssFixType::k3d,   GnssFixType::kFixed, GnssFixType::kFloat,
                                    GnssFixType::kNone, GnssFixType::kNone,  GnssFixType::kNone};
  if (f[6].size() != 1 || f[6][0] < '0' || f[6][0] > '8') return false;
  GnssFix fix = out.fix;
  fix.type = kTypes[f[6][0] - '0'];
  if (fix.type == GnssFixType::kNone) {
    out.fix = fix;
    return true;
  }
  if (!read_angle(f[2], f[3], "NS", 90, fix.latitude_deg)) return false;
  if (!read_angle(f[4], f[5], "EW", 180, fix.longitude_deg)) return false;
  double altitude = 0, separation = 0;
  if (!is_finite_number(f[9], altitude)) return false;
  if (f[11].empty()) {
    fix.type = GnssFixType::k2d;
  } else if (!is_finite_number(f[11], separation)) {
    return false;
  }
  fix.height_m = altitude + separation;
  out.fix = fix;
  return true;
}

// time, A, latitude, N, longitude, E, knots, course, ddmmyy, ...
bool NmeaReader::read_rmc(const std::string_view* f, Epoch& out) {
  if (!f[9].empty()) {
    int day = 0, month = 0, year = 0;
    const bool date = f[9].size() == 6 && two_digits(f[9], 0, day) && two_digits(f[9], 2, month) &&
                      two_digits(f[9], 4, year) && day >= 1 && day <= 31 && month >= 1 &&
                      month <= 12;
    if (!date) return false;
    days_ = days_since_1970(2000 + year, month, day);
    days_time_ns_ = out.time_of_day_ns;
    has_date_ = out.has_time;
  }
  if (f[2] != "A" || f[7].empty()) return f[2] == "A" || f[2] == "V";
  double knots = 0, course = 0;
  if (!is_finite_number(f[7], knots)) return false;
  if (!f[8].empty() && !is_finite_number(f[8], course)) return false;
  out.speed_m_s = knots * kKnot_m_s;
  out.course_deg = course;
  return true;
}

// course, T, course, M, knots, N, km/h, K, ...: finer than RMC, or all there is of velocity
bool NmeaReader::read_vtg(const std::string_view* f, Epoch& out) {
  if (!out.any) return true;  // of no time: nothing has come yet
  double kmh = 0, course = 0;
  if (f[7].empty()) return true;
  if (!is_finite_number(f[7], kmh)) return false;
  if (!f[1].empty() && !is_finite_number(f[1], course)) return false;
  out.speed_m_s = kmh * kKmh_m_s;
  if (!f[1].empty()) out.course_deg = course;
  return true;
}

// time, rms, semi-major, semi-minor, orientation, sigma latitude, longitude, altitude
bool NmeaReader::read_gst(const std::string_view* f, Epoch& out) {
  double north = 0, east = 0, up = 0;
  if (f[6].empty() && f[7].empty()) return true;
  if (!is_finite_number(f[6], north) || !is_finite_number(f[7], east)) return false;
  if (!is_finite_number(f[8], up) || north < 0 || east < 0 || up < 0) return false;
  out.fix.sigma_horizontal_m = std::sqrt((north * north + east * east) / 2);
  out.fix.sigma_vertical_m = up;
  return true;
}

void NmeaReader::tell(ReceiverFix& out) {
  out = ReceiverFix{};
  out.fix = epoch_.fix;
  const bool speed = (epoch_.kinds & (bit(kRmc) | bit(kVtg))) != 0;
  // A standing receiver tells no course.
  if (speed && out.fix.type != GnssFixType::kNone) {
    double s = 0, c = 1;
    // Courses beyond a turn are nonsense, and sincos has its limits.
    if (std::abs(epoch_.course_deg) <= 360) sincos(epoch_.course_deg * kPi / 180, s, c);
    out.fix.v_ned = Vec3(epoch_.speed_m_s * c, epoch_.speed_m_s * s, NAN);
    out.fix.has_velocity = true;
  }
  out.has_time = epoch_.has_time && has_date_;
  if (!out.has_time) return;
  // An epoch after midnight whose date has not come yet.
  int64_t days = days_;
  if (epoch_.time_of_day_ns < days_time_ns_ - kDay_ns / 2) ++days;
  out.t_utc = days * kDay_ns + epoch_.time_of_day_ns;
}

bool NmeaReader::flush(ReceiverFix& out) {
  const bool complete = epoch_.any && !epoch_.told && (epoch_.kinds & bit(kGga)) != 0;
  epoch_.told = true;
  if (complete) tell(out);
  return complete;
}

}  // namespace pirvs
