// What    Faults put by hand into a recording on its way to the sensors: what a cable, a driver,
//         a lens cap or a clock may do.
// In      SPEC, "kind:when" or "kind:whenxVALUE"; fault_help() lists the kinds. Times in seconds
//         after the recording's first frame: "A-B", from A until before B; "A", one item for what
//         happens to an item, else from A on. Items in the order of the recording.
// Out     The items as the sensors would then deliver them; pixels in memory of its own.
// Units   ns, rad/s, m/s^2, grey values.
// Errors  InputError: no such kind, a time or value that makes no sense, nothing there to break.
// Cost    a copy of the images for the kinds that change pixels.
// Source  issue "Faults by hand"; docs/faults.md says what the stack does about each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"
#include "bsp/replay/replay.h"
#include "tools/dataset/recording.h"
#include "tools/sim/random.h"

namespace pirvs::tools {

enum class FaultKind : uint8_t {
  kCam0,
  kCam1,
  kBlack,
  kWhite,
  kFrozen,
  kGain,
  kFrames,
  kLate,
  kImu,
  kNan,
  kSpike,
  kSaturate,
  kStuck,
  kStamp,
  kClock,
  kClockImu,
  kClockCam,
  kCount
};

struct Fault {
  FaultKind kind = FaultKind::kCount;
  TimeNs begin = 0, end = INT64_MAX;  // after the first frame
  bool once = false;                  // the first item at or after begin alone
  double value = 0;                   // share, factor or seconds
  std::string spec;
};

Fault parse_fault(const std::string& spec);
std::string fault_help();

// The way of one run's items through its faults, in the order in which the faults were given.
class FaultLine {
 public:
  FaultLine(const std::vector<Fault>& faults, const Recording& recording);

  // false: the item does not arrive. A frame's images stay valid until another one passes in the
  // slot of its id.
  bool pass(ImuSample& sample);
  bool pass(StereoFrame& frame);

  std::vector<Count> applied() const;  // items changed, by fault as it was written

 private:
  struct Stage {
    Fault fault;
    size_t applied = 0;
    bool imu_done = false, frame_done = false;  // of `once`
    size_t seen = 0;                            // samples within the time, for every tenth
    Random random{1, 0};
    ImuSample held;  // the last sample before
    bool has_held = false;
    TimeNs held_t = 0;
    uint8_t held_present = 0;
    std::vector<uint8_t> held_pixels[kCamerasMax], next_pixels[kCamerasMax];
  };

  bool hits(Stage& stage, TimeNs since_begin, bool& done);
  bool break_sample(Stage& stage, ImuSample& sample);
  bool break_frame(Stage& stage, StereoFrame& frame);
  void break_pixels(Stage& stage, StereoFrame& frame);

  std::vector<Stage> stages_;
  std::vector<uint8_t> shown_[bsp::kReplayFrames][kCamerasMax];  // by the slot of the frame
  TimeNs first_frame_ = 0;
  TimeNs camera_time_offset_ = 0;
};

}  // namespace pirvs::tools
