// Poses of the device as lines of text, on standard output and as datagrams: those of
// modules/output/pose_text.h, followed by the health's name and the confidence.
// In      configure(), send(), close(): from the core that runs core 0 of the plan.
// Out     send(): all poses that wait in the feed. frame(): the pose of a frame, where frames are
//         wanted on standard output. event(): an edge of SYNC_IN as a comment, `# sync_in T LEVEL`,
//         followed by the pose at its time where there is one.
// Errors  Nothing waits for a reader: what cannot be written or sent now is dropped and counted. A
//         socket that cannot be had: configure() says kBusFault or kNotFound.
// Cost    ~5 us a pose and reader: its system call. No heap.
// Source  docs/device.md.
#pragma once

#include "board/linux/pins.h"
#include "board/linux/settings.h"
#include "core/base/counter.h"
#include "modules/app/app_sinks.h"
#include "modules/output/pose_feed.h"

namespace pirvs::board {

class PoseOutput {
 public:
  Status configure(const Settings& settings, PoseFeed& feed);
  void frame(const FrameReport& report);
  // Poses are shown to `seen` as they go out.
  void send(void (*seen)(const Pose&));
  void event(const SyncEvent& event);
  void close();
  // Whoever wants the lines as well.
  void also(void (*line)(const TextWriter&)) { also_ = line; }

  uint32_t sent() const { return sent_; }
  uint32_t written() const { return written_; }
  uint32_t dropped() const { return dropped_; }
  uint64_t overtaken() const { return feed_ != nullptr ? feed_->lost(consumer_) : 0; }

 private:
  void write_line(const TextWriter& line);

  PoseFeed* feed_ = nullptr;
  int consumer_ = 0;
  TextOutput text_ = TextOutput::kNone;
  void (*also_)(const TextWriter&) = nullptr;
  bool has_socket_ = false;
  bsp::Socket socket_;
  bsp::Endpoint to_;
  Counter sent_, written_, dropped_;
};

}  // namespace pirvs::board
