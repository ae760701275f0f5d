// What    Writes a recording as an ASL folder, or as an MCAP file of ROS 2 messages.
// In      An open Recording: frames, samples and truth as they are played, in order of time.
// Out     write_asl: OUT/mav0 with cam0, cam1, imu0, state_groundtruth_estimate0, and gnss0 and
//         wheel0 of an ASL folder as they were. write_mcap: OUT with /cam0/image_raw/compressed,
//         /cam1/..., /imu0 and /pose, and the calibration beside it, as OUT with .cfg for .mcap.
//         Both read back as the same recording: numbers are exact but for the last bit of a
//         rotation, which readers make exact once more; images are the same bytes, or PNG where
//         they were in no file. All of it, or nothing.
// Frames  as recording.h.
// Units   ns; rad/s, m/s^2; m.
// Errors  InputError: OUT is there already, or cannot be written. Counted: images that could not be
//         read. Noted: what the form has no place for.
// Cost    that of copying the images.
// Source  Burri et al., IJRR 2016; mcap.dev; docs/formats.md.
#pragma once

#include <functional>
#include <string>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

using FrameDone = std::function<void(size_t)>;  // how many are

void write_asl(const Recording& recording, const std::string& out, const FrameDone& done,
               InputLog& log);
void write_mcap(const Recording& recording, const std::string& out, const FrameDone& done,
                InputLog& log);

}  // namespace pirvs::tools
