// What    Plays a recording's frames in order, decoded ahead by a thread of its own, so that
// reading
//         PNG and JPEG costs the thread that asks for frames no CPU time.
// In      An open Recording, which must outlive the player.
// Out     front(): the oldest frame not yet popped; its images stay valid until pop(). An image
//         that is missing, cut off or of the wrong size is left out of the frame (present) and
//         counted by name.
// Frames  image[c] is camera c, 8-bit grey, as recorded (distorted).
// Units   t in ns: as stamped by the camera; the sensor door applies camera_time_offset_ns.
// Errors  InputError on construction: none of the first images can be read, or their size is not
//         the calibration's.
// Cost    kFramesAhead stereo frames of memory, allocated once. PNG 752 x 480: ~3 ms an image, on
//         the decoder's thread.
// Source  DESIGN.md: decoding lives in tools; timing.csv has CPU time of the pipeline alone.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "bsp/api/camera.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

class Player {
 public:
  explicit Player(const Recording& recording);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  const StereoFrame* front();  // waits for the decoder; nullptr at the end of the recording
  void pop();

  size_t frames_played() const { return popped_; }
  std::vector<Count> rejected() const;

 private:
  enum class Read : uint8_t { kGood, kMissing, kCutOff, kUndecodable, kWrongSize, kCount };
  static constexpr size_t kFramesAhead = 12;

  struct Slot {
    StereoFrame frame;
    std::vector<uint8_t> pixels[2];
  };

  const Recording& recording_;
  std::vector<Slot> slots_;
  std::vector<uint8_t> file_;
  size_t decoded_ = 0;  // frames handed over by the decoder
  size_t popped_ = 0;   // frames given back by the reader
  size_t failed_[static_cast<size_t>(Read::kCount)] = {};
  bool stop_ = false;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::thread decoder_;

  void check_first_images();
  void decode_all();
  void decode_frame(const FrameFiles& files, Slot& slot);
  Read decode_image(const std::string& path, int camera, std::vector<uint8_t>& pixels);
};

}  // namespace pirvs::tools
