// What    `pirvs run --mavlink`: what a device would tell an autopilot, during a run.
// In      udp:HOST:PORT, or a file; settings of the link as the device's configuration has them
//         (board/linux/link_settings.h).
// Out     A file holds each frame behind 8 bytes: its time in us, big-endian, on the clock of the
//         recording's stamps (the format of ground stations' .tlog, whose clock is UNIX's).
//         Datagrams carry one frame each, and what comes back is obeyed. In real time the link has
//         a thread of its own, as on a device; as fast as possible, core 0 serves it and its clock
//         is that of the newest sample.
// Errors  InputError: no such host, no such setting, a file that cannot be written.
// Source  mavlink.io, "Telemetry logs"; docs/integration.md.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "board/linux/robot_link.h"
#include "modules/link/replay_link.h"
#include "tools/run/run_log.h"

namespace pirvs::tools {

class RobotOutput : public RunListener {
 public:
  RobotOutput(const std::string& where, const std::vector<std::string>& settings, bool real_time);
  RobotOutput(const RobotOutput&) = delete;
  RobotOutput& operator=(const RobotOutput&) = delete;

  void frame(const FrameReport& report) override;
  void health(TimeNs t, HealthState state, const char* what) override;
  void answer(const Answer& answer) override;
  void open(App& app, const ImuNoise& noise);
  void after_step();
  void close();                                      // InputError: what could not be written
  void add_counters(std::vector<Count>& out) const;  // link.*

 private:
  std::string where_;
  board::LinkSettings settings_;
  bool real_time_;
  bool started_ = false;         // a frame has come
  const char* fault_ = nullptr;  // of the thread
  board::RobotLink wire_;

  std::ofstream file_;
  ReplayLink to_file_;
};

}  // namespace pirvs::tools
