// What    Plays a recording's frames in order, decoded ahead by a thread of its own, so that
//         reading PNG and JPEG costs the thread that asks for frames no CPU time.
// In      An open Recording, which must outlive the player.
// Out     next(): the next frame; it stays valid until release(), from any thread and in any order.
//         An image that is missing, cut off or of the wrong size is left out of the frame (present)
//         and counted by name. info.sequence: the frame's place in the recording.
// Frames  image[c] is camera c, 8-bit grey, distorted, turned as the recording says.
// Units   t in ns: as stamped by the camera; the sensor door applies camera_time_offset_ns.
// Errors  InputError on construction: none of the first images can be read, or their size is not
//         the calibration's.
// Cost    kSlots stereo frames of memory, allocated once. PNG 752 x 480: ~3 ms an image, on
//         the decoder's thread.
// Source  DESIGN.md: decoding lives in tools; timing.csv has CPU time of the pipeline alone.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "bsp/replay/replay.h"
#include "tools/dataset/image_store.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

class Player {
 public:
  explicit Player(const Recording& recording);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  // Waits for the decoder, for ever if all slots are held; nullptr at the end of the recording.
  const StereoFrame* next();
  void release(const StereoFrame* frame);

  size_t frames_played() const { return played_; }
  std::vector<Count> rejected() const;

 private:
  using Read = ImageRead;
  static constexpr size_t kSlots = 12                     // decoded ahead
                                   + bsp::kReplayFrames;  // lent

  struct Slot {
    StereoFrame frame;
    std::vector<uint8_t> pixels[kCamerasMax];
    bool free = true;
  };

  const Recording& recording_;
  std::vector<Slot> slots_;
  std::vector<uint8_t> file_;
  std::deque<Slot*> ready_;  // decoded, not yet played
  size_t played_ = 0;
  size_t failed_[static_cast<size_t>(Read::kCount)] = {};
  bool stop_ = false;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::thread decoder_;

  void check_first_images();
  void decode_all();
  Slot* wait_for_free_slot();
  void decode_frame(const FrameFiles& files, Slot& slot);
  Read decode_image(const std::string& path, int camera, std::vector<uint8_t>& pixels);
  Read load(const std::string& path, cv::Mat& image);
  cv::Size wrong_size_;  // of the last image that was of another size than the calibration's
};

}  // namespace pirvs::tools
