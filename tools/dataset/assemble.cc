#include "tools/dataset/assemble.h"

#include <algorithm>

namespace pirvs::tools {

void take_rig(const Rig& rig, const std::string& where, Recording& recording) {
  recording.calibration = rig.calibration;
  for (int c = 0; c < 2; ++c) recording.turns[c] = rig.turns[c];
  if (!rig.has_rate && recording.imu.size() > 1) {
    const TimeNs step = std::max<TimeNs>(1, interval(recording.imu));
    recording.calibration.imu.rate_hz = 1e9 / double(step);
  }
  check_sense(recording.calibration, where);
}

void add_frames(const Rig& rig, const std::vector<ListedImage>& left,
                const std::vector<ListedImage>& right, const std::string& left_name,
                Recording& recording) {
  constexpr TimeNs kWorthAWord = 20'000'000;
  note_gaps(left, left_name, kWorthAWord, recording);
  // Stamps of one exposure come to one time on the IMU's clock.
  const TimeNs right_later = rig.shift_ns[0] - rig.shift_ns[1];
  for (const PairedImages& pair : pair_images(left, right, right_later, recording)) {
    FrameFiles frame;
    frame.t = pair.t;
    for (int c = 0; c < 2; ++c) frame.image[c] = pair.file[c];
    recording.frames.push_back(frame);
  }
}

std::vector<ImuSample> join_sensors(const std::vector<ImuSample>& gyro,
                                    const std::vector<ImuSample>& accel) {
  std::vector<ImuSample> out;
  size_t j = 1;
  for (const ImuSample& sample : gyro) {
    while (j < accel.size() && accel[j].t < sample.t) ++j;
    if (j >= accel.size()) break;
    if (accel[j - 1].t > sample.t) continue;
    ImuSample both = sample;
    if (accel[j].t == sample.t) {
      both.f_B = accel[j].f_B;  // to the bit
    } else {
      const double share = double(sample.t - accel[j - 1].t) / double(accel[j].t - accel[j - 1].t);
      both.f_B = accel[j - 1].f_B + share * (accel[j].f_B - accel[j - 1].f_B);
    }
    out.push_back(both);
  }
  return out;
}

}  // namespace pirvs::tools
