// What    Reads the fixes of a GNSS receiver.
// In      A table as in an ASL folder's gnss0/data.csv: timestamp, latitude, longitude [deg],
//         height above the ellipsoid [m], v_north, v_east, v_down, sigma_horizontal,
//         sigma_vertical, sigma_velocity, fix (none, 2d, 3d, float, fixed); empty velocity: not
//         measured. Or a solution of RTKLIB (.pos), or the bytes of a receiver: .ubx, .nmea.
// Out     Fixes in order of time. t: the stamps of a table as they are; of the others UTC in Unix
//         time, in which case the recording must have it, too.
// Units   deg, m, m/s, ns.
// Errors  InputError: a file that cannot be read, a line that is no data, no fixes. Rejected and
//         counted by name: rows cut off, not after the row before, without a time.
// Source  docs/gnss.md; RTKLIB 2.4.2 manual, appendix B.1.
#pragma once

#include <string>
#include <vector>

#include "modules/door/items.h"
#include "tools/dataset/input_log.h"

namespace pirvs::tools {

enum class GnssFormat : uint8_t { kTable, kRtklib, kUbx, kNmea };
GnssFormat gnss_format(const std::string& path);  // by the name's ending

std::vector<GnssFix> read_gnss(const std::string& path, GnssFormat format, InputLog& log);

}  // namespace pirvs::tools
