// The application as an object that a program holds (pirvs.h): its life, its poses, its commands.
// In      Calls as pirvs.h says, by the threads that it says; arguments are checked by pirvs.cc.
// Out     Statuses of pirvs.h; why(): of the last refusal, on the thread that met it.
// Frames, units  as in pirvs.h.
// Errors  as pirvs.h says.
// Cost    Static memory alone. Threads take heap as they start, in start().
#pragma once

#include <pthread.h>

#include <atomic>

#include "board/library/pirvs.h"
#include "core/base/text.h"
#include "core/store/mailbox.h"
#include "core/store/newest_ring.h"
#include "modules/app/app.h"

namespace pirvs::board {

// Keeps the reason for the caller's thread, and returns the status.
pirvs_status refuse(pirvs_status status, const char* what, const char* where = nullptr);
const char* why();

// Many methods: the functions of pirvs.h, most of them a few lines.
class Slam {
 public:
  pirvs_status create(const pirvs_config& config);
  pirvs_status start();
  pirvs_status feed(const pirvs_imu& sample);
  pirvs_status feed(const pirvs_images& images);
  pirvs_status next_pose(int which, pirvs_pose& out);
  pirvs_status next_news(pirvs_news& out);
  pirvs_status points(pirvs_points& out);
  void state(pirvs_state& out);
  pirvs_status counter(int index, const char*& name, uint64_t& value) const;
  pirvs_status set_parameter(const char* name, float value);
  pirvs_status command(const Command& command);
  pirvs_status stop();

 private:
  enum class Life : uint8_t { kCreated, kRuns, kStopped, kFailed };
  static constexpr int kPointsMax = kCamerasMax * kTracksMax;

  struct Points {
    TimeNs t = 0;
    int count = 0;
    SeenPoint point[kPointsMax];
  };

  // Counts resets over the whole life of the instance: App's own count begins anew with each start.
  class Resets {
   public:
    uint32_t count(uint32_t told) {
      if (told != told_) ++count_;
      told_ = told;
      return count_;
    }
    void expect_another() { told_ = UINT32_MAX; }

   private:
    uint32_t told_ = 0, count_ = 0;
  };

  AppSinks sinks();
  void give_out();
  void call_back(void (*to)(void*, const pirvs_pose*), const pirvs_pose& pose) const;
  void on_tracked(TimeNs t, const Tracker& tracker);
  void on_news(TimeNs t, HealthState state, const char* what);
  void on_answer(const Answer& answer);
  void on_imu(const ImuSample& sample) { w_B_ = sample.w_B; }
  void drain();
  void run();
  pirvs_status wait_for(uint32_t ticket);
  pirvs_status changed(Status status, const char* what);
  bool stepped() const { return config_.mode == PIRVS_STEPPED; }

  pirvs_config config_;
  Calibration calibration_;
  AppParams params_;
  std::atomic<Life> life_{Life::kCreated};
  pthread_t thread_;
  std::atomic<bool> started_{false};
  Status ended_ = Status::kOk;

  // Written and read on the core of the sensor door alone.
  int given_ = -1;  // consumer of App's poses, for the callback
  Vec3 w_B_ = Vec3::Zero();
  Resets frame_resets_, given_resets_;
  // Written and read by the program's reading thread alone.
  int taken_ = -1;  // consumer of App's poses, for next_pose()
  Resets taken_resets_;
  // Written on the stack's threads, read by the program's.
  NewestRing<pirvs_pose, kPosesKept> frames_;
  NewestRing<pirvs_news, 16> news_;
  Mailbox<Points> points_;
  std::atomic<uint8_t> health_{0};
  std::atomic<bool> in_map_{false};
  std::atomic<float> confidence_{0};
  std::atomic<uint32_t> reasons_{0};
  std::atomic<uint64_t> imu_fed_{0}, imu_lost_{0}, images_fed_{0}, images_lost_{0};

  pthread_mutex_t commands_ = PTHREAD_MUTEX_INITIALIZER;  // one is under way
  Answer answer_;
  std::atomic<uint32_t> answered_{0};  // ticket + 1
};

}  // namespace pirvs::board
