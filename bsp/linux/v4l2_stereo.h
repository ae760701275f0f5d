// Two V4L2 cameras as the stereo camera of bsp/api/camera.h; or one alone.
// In      configure(), poll(): from one core; retain(), release(): from any.
// Out     poll: as camera_poll. kTrigger: one trigger drives both sensors, so that images of one
//         pulse have counts that differ by a constant, which is found by stamps at the start; each
//         pair is checked by its stamps, and counts that no longer agree with them are found anew.
//         Never by the order of arrival. kStamp: free-running cameras; images nearest in time, less
//         than half a period apart, are a pair and the older one is late. An image whose partner
//         was lost, or does not come for partner_wait_ns, goes out alone.
//         lost_before: by the trigger count, pulses of which no image came out.
// Errors  As camera_poll; kBusFault: no camera is there, as GoneDevice has it. One that is there
//         alone gives frames with one image.
//         range, control: as camera_range and camera_control. A camera that is not there now is
//         told when it comes back.
// Cost    No copy; the sum of its nodes.
// Source  bsp/linux/v4l2_node.h; core/store/lending.h.
#pragma once

#include "bsp/linux/v4l2_node.h"
#include "core/store/lending.h"

namespace pirvs::bsp {

enum class Pairing : uint8_t { kTrigger, kStamp };

struct V4l2StereoSetup {
  V4l2Setup camera[kCamerasMax];
  int cameras = 2;
  Pairing pairing = Pairing::kTrigger;
  TimeNs pair_ns_max = 1'000'000;       // stamps of one trigger differ by less
  TimeNs partner_wait_ns = 20'000'000;  // after the arrival of the first of two
  TimeNs period_ns = 50'000'000;        // nominal, for kStamp
};

struct StereoCounters {
  Counter pairs, halves, counts_found, counts_wrong, after_its_half;
};
inline constexpr CounterRow<StereoCounters> kStereoCounterRows[] = {
    {"pairs", &StereoCounters::pairs},
    {"halves", &StereoCounters::halves},
    {"counts_found", &StereoCounters::counts_found},      // how the counts of both fit together
    {"counts_wrong", &StereoCounters::counts_wrong},      // stamps disagreed with them
    {"after_its_half", &StereoCounters::after_its_half},  // came when its partner had gone alone
};
static_assert(every_counter_is_in(kStereoCounterRows));

class V4l2Stereo {
 public:
  void configure(const V4l2StereoSetup& setup, const DeviceNews& news,
                 const SystemCalls& calls = kSystemCalls);

  Status poll(StereoFrame& out);
  void retain(FrameId id) { lending_.retain(id); }
  void release(FrameId id);
  void close();
  Result<CameraRange> range() const;
  Status control(const CameraControl& control);

  // What becomes readable when poll() may have more of this camera; -1: it need not be waited for.
  int fd_to_wait_for(int c) const { return heads_[c].here ? -1 : nodes_[c].fd(); }
  const V4l2Node& node(int c) const { return nodes_[c]; }
  const StereoCounters& counters() const { return counters_; }

 private:
  struct Head {
    V4l2Image image;
    bool here = false;
  };
  // Which images go out next: a bit a camera. 0: none yet.
  using Choice = uint8_t;

  bool fetch(int c);
  Choice choose();
  Choice choose_by_trigger();
  Choice choose_by_stamp() const;
  Choice alone();
  void find_counts();
  bool is_past(int c) const;
  uint32_t count_of(int c) const;
  void drop(int c);
  Status lend(Choice choice, StereoFrame& out);

  V4l2StereoSetup setup_;
  V4l2Node nodes_[kCamerasMax];
  Head heads_[kCamerasMax];
  uint32_t starts_[kCamerasMax] = {};
  bool counts_known_ = false;
  uint32_t count_offset_ = 0;  // count of camera 0 minus that of camera 1
  bool has_last_ = false;
  uint32_t last_count_ = 0;  // of the last frame that went out
  StereoCounters counters_;
  GoneDevice gone_;
  Lending<StereoFrame, kFramesLentMax> lending_;
  int lent_[kFramesLentMax][kCamerasMax];  // buffers; -1: none
};

}  // namespace pirvs::bsp
