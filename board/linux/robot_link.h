// The robot's link (modules/link) on a wire of Linux: datagrams, a serial line, or both at once.
// In      open(): where to, and the stack. health(), answer(): what the stack tells, from core 0.
//         Then either start_thread(), or poll() again and again from one core, with its clock.
// Out     Frames to the wire; fixes, wheels and commands to the stack.
// Errors  open, start_thread: nullptr, or why not. Nothing waits for the other side: a frame for
//         which there is no room is dropped and counted; a serial frame that has begun is ended
//         before another one begins. A tty or a network that is not there is looked for every
//         kRetry_ns. Datagrams of others than the robot's address are refused and counted. Whoever
//         floods is heard kBytesAtOnce bytes a millisecond; the rest the kernel drops.
// Cost    A thread of its own, as urgent as any program and no more, that wakes twice as often as
//         the IMU while poses come: a question for the time is answered within ~0.1 ms, whatever
//         the cores of the stack do. 80 kB with its ring of poses. No heap.
// Source  docs/integration.md.
#pragma once

#include <pthread.h>

#include <atomic>

#include "board/linux/link_settings.h"
#include "core/store/ring.h"
#include "modules/app/app.h"

namespace pirvs::board {

struct RobotLinkCounters {
  Counter opened, strangers, poses_overtaken;
};
inline constexpr CounterRow<RobotLinkCounters> kRobotLinkRows[] = {
    {"opened", &RobotLinkCounters::opened},        // a tty or a socket came
    {"strangers", &RobotLinkCounters::strangers},  // datagrams that are not the robot's
    {"poses_overtaken", &RobotLinkCounters::poses_overtaken},
};
static_assert(every_counter_is_in(kRobotLinkRows));

class RobotLink {
 public:
  static constexpr TimeNs kRetry_ns = 500'000'000;
  static constexpr size_t kBytesAtOnce = 8192;

  ~RobotLink() { close(); }

  // `now`: the clock of the sensors' stamps, from any core.
  const char* open(const LinkSettings& setup, const ImuNoise& noise, App& app, TimeNs (*now)());
  const char* start_thread();
  void close();

  void health(HealthState state, const char* what);
  void answer(const Answer& answer);
  void poll();

  bool runs() const { return runs_; }  // a thread does
  // 0: there is no socket yet.
  uint16_t port() const;

  template <class Visit>
  void for_each_counter(Visit&& visit) const {
    pirvs::for_each_counter(link_.counters(), kLinkRows, visit);
    pirvs::for_each_counter(link_.parser_counters(), mavlink::kParserRows, visit);
    pirvs::for_each_counter(counters_, kRobotLinkRows, visit);
  }

 private:
  static constexpr size_t kNewsMax = 32;

  struct News {
    bool is_answer = false;
    Answer answer;
    HealthState state = HealthState::kInitializing;
    char what[64] = "";
  };

  bool send(const uint8_t* frame, size_t size);
  void open_wire(TimeNs now);
  void close_serial();
  bool flush();
  bool receive();
  void take_news();
  void run();
  void wait(bool flooded);

  Link link_;
  LinkSettings setup_;
  App* app_ = nullptr;
  TimeNs (*now_)() = nullptr;
  int consumer_ = -1;
  Ring<News, kNewsMax> news_;
  TimeNs retry_t_ = INT64_MIN, pose_t_ = INT64_MIN / 2;  // pose_t_: when the last one came
  bool has_socket_ = false;
  bsp::Socket socket_;
  int fd_ = -1;
  uint8_t waiting_[mavlink::kFrameMax];  // the end of a frame
  size_t waiting_from_ = 0, waiting_end_ = 0;
  pthread_t thread_{};
  bool runs_ = false;
  std::atomic<bool> stop_{false};
  RobotLinkCounters counters_;
};

}  // namespace pirvs::board
