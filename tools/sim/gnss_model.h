// What    What a GNSS receiver would have told along a path.
// In      The truth as poses (200 Hz); a kind of receiver; where the world of the truth lies on the
//         Earth; seed.
// Out     A folder as an ASL recording's gnss0: data.csv, sensor.yaml. The first fix comes 13 ms
//         after the first pose, so that none has a frame's time by chance.
// Frames  W: the truth's world, z up, its x axis `heading` counter-clockwise of east.
// Units   m, m/s, s, deg. sigma: white noise of one axis.
// Errors  InputError: unknown kind, a folder that cannot be written, a truth of one pose.
// Cost    ~1 us a fix.
// Source  sigmas: what receivers claim (u-blox M8, F9P data sheets), not their correlation in time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct GnssOptions {
  std::string kind;      // rtk, float, spp; empty: no receiver
  double rate_hz = 0;    // 0: 5 for rtk and float, 1 for spp
  double sigma_m = 0;    // horizontal; 0: 0.01, 0.3, 1.5; vertical 1.5 times as much
  bool velocity = true;  // is measured, too
  double claimed = 1;    // the sigma that it tells, over the true one
  std::vector<double> antenna = {0, 0, 0};  // in B
  double latency_s = 0;
  double outage_from_s = 0, outage_for_s = 0;
  double multipath_m = 0, multipath_from_s = 0, multipath_for_s = 0;
  // Beside that time: from, to [deg], counter-clockwise from east, as seen from the middle of the
  // path. There a wall throws signals back: the same error each time the antenna is at a place.
  std::vector<double> multipath_sector;
  double latitude_deg = 47.3977, longitude_deg = 8.5456, height_m = 488;  // of the truth's origin
  double heading_deg = 30;
};

void write_gnss(const GnssOptions& options, const Trajectory& truth, uint64_t seed,
                const std::string& folder);

}  // namespace pirvs::tools
