// What    A replay in real time, as a view shows it, and whose commands it obeys.
// In      open(): the configured App; then what the run tells (run_log.h), on core 0.
// Out     to the scene: poses, frames, points as they are seen, images with tracks while a page
//         looks, counters and this machine's load once a second. Commands go to the App; its
//         answers come back to the page.
// Errors  a command that cannot be read is answered by why.
// Cost    core 0: a pose 0.3 us, a frame below 2 us; 12 times a second images, ~80 us; 5 times
//         points, ~20 us.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "tools/run/run_log.h"
#include "tools/view/image_encoder.h"
#include "tools/view/view.h"

namespace pirvs::tools {

class ReplayView : public RunListener {
 public:
  // `files`: the folder of `map load`.
  ReplayView(View& view, const Recording& recording, std::string files);
  ~ReplayView() override;
  ReplayView(const ReplayView&) = delete;
  ReplayView& operator=(const ReplayView&) = delete;

  void open(App& app);
  // A map that was loaded, or will be; "": none is. From any thread, after open().
  void show_map_later(const std::string& file);
  void close(const std::string& why);

  void frame(const FrameReport& report) override;
  void tracked(TimeNs t, const StereoFrame& images, const Tracker& tracker) override;
  void pose(const Pose& pose) override;
  void health(TimeNs t, HealthState state, const char* what) override;
  void fused(const FusedPose& pose) override;
  void fix(const GnssFix& fix, FixGate gate) override;
  void answer(const Answer& answer) override;

 private:
  void obey(const std::string& id, const std::string& line);
  void count();  // a thread's
  void show_map(const std::string& file);

  View& view_;
  ViewScene& scene_;
  ImageEncoder encoder_;
  App* app_ = nullptr;
  TimeNs points_t_ = 0;  // of the next ones, on this machine's clock
  bool has_fused_ = false;
  struct Asked {
    std::string id, text;  // the page's id, the command's text
  };
  std::mutex asked_mutex_;
  std::map<uint32_t, Asked> asked_;  // by ticket
  std::mutex mutex_;
  std::condition_variable wake_;
  const std::string files_;
  std::string map_;
  bool stop_ = false, map_is_new_ = false;
  std::thread thread_;
};

}  // namespace pirvs::tools
