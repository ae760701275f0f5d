#include "tools/dataset/gnss_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "modules/gnss/nmea.h"
#include "modules/gnss/ubx.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

constexpr const char* kTypes[] = {"none", "2d", "3d", "float", "fixed"};
constexpr const char* kWhat = "GNSS fixes";
constexpr const char* kRepair = "remove or repair the line";

// In order of time; what is not later than the one before is rejected.
void keep(const GnssFix& fix, std::vector<GnssFix>& fixes, InputLog& log) {
  if (!fixes.empty() && fix.t <= fixes.back().t) return log.count("gnss_stamps_not_rising");
  fixes.push_back(fix);
}

bool read_type(std::string_view text, GnssFixType& out) {
  for (size_t i = 0; i < std::size(kTypes); ++i) {
    if (text != kTypes[i]) continue;
    out = GnssFixType(i);
    return true;
  }
  return false;
}

std::vector<GnssFix> read_csv(const std::string& path, InputLog& log) {
  TextTable table(path, kWhat);
  std::vector<GnssFix> fixes;
  enum Column : size_t { kPlace = 1, kVelocity = 4, kSigma = 7, kType = 10, kColumns };
  while (table.next()) {
    const auto t = table.stamp();
    GnssFix fix;
    bool complete = t && table.columns() >= kColumns && read_type(table.text(kType), fix.type);
    if (!complete && table.cut_off()) {
      log.count("gnss_rows_truncated");
      continue;
    }
    const auto value = [&](size_t column) {
      const auto number = complete ? table.number(column) : std::nullopt;
      complete = complete && number && std::isfinite(*number);
      return complete ? *number : 0.0;
    };
    if (complete) fix.t = *t;
    fix.latitude_deg = value(kPlace);
    fix.longitude_deg = value(kPlace + 1);
    fix.height_m = value(kPlace + 2);
    fix.has_velocity = complete && !table.text(kVelocity).empty();
    for (size_t k = 0; k < 3 && fix.has_velocity; ++k) {
      const bool measured = k < 2 || !table.text(kVelocity + k).empty();
      fix.v_ned[int(k)] = measured ? value(kVelocity + k) : NAN;
    }
    fix.sigma_horizontal_m = value(kSigma);
    fix.sigma_vertical_m = value(kSigma + 1);
    if (fix.has_velocity) fix.sigma_velocity_m_s = value(kSigma + 2);
    if (!complete) {
      table.fail(
          "needs time, 3 of place, 3 of velocity or none, 3 sigmas, and none, 2d, 3d, float "
          "or fixed",
          kRepair);
    }
    keep(fix, fixes, log);
  }
  return fixes;
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  if (!file || !(bytes << file.rdbuf())) {
    throw InputError("cannot read the GNSS fixes", path, "check the path");
  }
  return bytes.str();
}

template <class Reader, class Counters, size_t N>
std::vector<GnssFix> read_bytes(const std::string& path, const CounterRow<Counters> (&rows)[N],
                                InputLog& log) {
  Reader reader;
  ReceiverFix read;
  std::vector<GnssFix> fixes;
  const auto take = [&] {
    if (!read.has_time) return log.count("gnss_without_time");
    read.fix.t = read.t_utc;
    keep(read.fix, fixes, log);
  };
  for (const char c : bytes_of(path)) {
    if (reader.take(uint8_t(c), read)) take();
  }
  while (reader.flush(read)) take();
  for_each_counter(reader.counters(), rows, [&](const char* name, uint32_t n) {
    log.rejected.push_back({name, n});
  });
  return fixes;
}

// A solution of RTKLIB: degrees, the time of GPS or UTC as the heading says.
std::vector<GnssFix> read_pos(const std::string& path, InputLog& log) {
  constexpr TimeNs kSecond_ns = 1'000'000'000;
  constexpr int kLeap_s = 18;  // GPS is ahead of UTC by that since 2017
  constexpr GnssFixType kTypes[] = {GnssFixType::kNone, GnssFixType::kFixed, GnssFixType::kFloat,
                                    GnssFixType::k3d,   GnssFixType::k3d,    GnssFixType::k3d,
                                    GnssFixType::k3d};
  std::istringstream lines(bytes_of(path));
  std::vector<GnssFix> fixes;
  bool gps = true;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!line.empty() && line[0] == '%') {
      if (line.find("UTC") != std::string::npos) gps = false;
      continue;
    }
    int year = 0, month = 0, day = 0, hour = 0, minute = 0;
    double second = 0, quality = 0, satellites = 0, sd[3] = {}, other[5] = {}, v[3] = {},
           sv[3] = {};
    GnssFix fix;
    const int read = std::sscanf(line.c_str(),
                                 "%d/%d/%d %d:%d:%lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf "
                                 "%lf %lf %lf %lf %lf %lf %lf "
                                 "%lf",
                                 &year, &month, &day, &hour, &minute, &second, &fix.latitude_deg,
                                 &fix.longitude_deg, &fix.height_m, &quality, &satellites, &sd[0],
                                 &sd[1], &sd[2], &other[0], &other[1], &other[2], &other[3],
                                 &other[4], &v[0], &v[1], &v[2], &sv[0], &sv[1], &sv[2]);
    constexpr int kPlace = 14, kVelocity = 25;
    if (read <= 0 && line.find_first_not_of(" \r") == std::string::npos) continue;
    const bool good = read >= kPlace && year >= 1980 && year < 2200 && month >= 1 && month <= 12 &&
                      day >= 1 && day <= 31 && second >= 0 && second < 61 && quality >= 0 &&
                      quality <= 6 && std::isfinite(fix.latitude_deg + fix.longitude_deg) &&
                      std::isfinite(fix.height_m + sd[0] + sd[1] + sd[2]);
    if (!good && lines.eof()) {
      log.count("gnss_rows_truncated");
      continue;
    }
    if (!good) {
      throw InputError("GNSS fixes: not a row of RTKLIB's solution",
                       path + " line " + std::to_string(number), kRepair);
    }
    const int64_t days = days_since_1970(year, month, day);
    fix.t = (days * 86400 + hour * 3600 + minute * 60 - (gps ? kLeap_s : 0)) * kSecond_ns +
            from_seconds(second);
    fix.type = kTypes[int(quality)];
    fix.sigma_horizontal_m = std::sqrt((sd[0] * sd[0] + sd[1] * sd[1]) / 2);
    fix.sigma_vertical_m = sd[2];
    fix.has_velocity = read >= kVelocity && std::isfinite(v[0] + v[1] + v[2] + sv[0] + sv[1]);
    if (fix.has_velocity) fix.v_ned = Vec3(v[0], v[1], -v[2]);
    if (fix.has_velocity) fix.sigma_velocity_m_s = std::sqrt((sv[0] * sv[0] + sv[1] * sv[1]) / 2);
    keep(fix, fixes, log);
  }
  return fixes;
}

}  // namespace

GnssFormat gnss_format(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension();
  return ending == ".ubx"    ? GnssFormat::kUbx
         : ending == ".nmea" ? GnssFormat::kNmea
         : ending == ".pos"  ? GnssFormat::kRtklib
                             : GnssFormat::kTable;
}

std::vector<GnssFix> read_gnss(const std::string& path, GnssFormat format, InputLog& log) {
  std::vector<GnssFix> fixes;
  switch (format) {
    case GnssFormat::kTable:
      fixes = read_csv(path, log);
      break;
    case GnssFormat::kRtklib:
      fixes = read_pos(path, log);
      break;
    case GnssFormat::kUbx:
      fixes = read_bytes<UbxReader>(path, kUbxCounters, log);
      break;
    case GnssFormat::kNmea:
      fixes = read_bytes<NmeaReader>(path, kNmeaCounters, log);
  }
  if (fixes.empty()) throw InputError("no GNSS fixes", path, "check the file");
  return fixes;
}

}  // namespace pirvs::tools
