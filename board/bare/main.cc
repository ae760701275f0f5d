// The whole stack on a recording that the loader has put in RAM.
// In      The recording (bsp/replay/pack.h) and the words of the command line:
//           cores=N         how many cores (default: all of the board)
//           pace=free       mapping may lag, as on a device; default: lockstep, the same bytes as
//                           on one core
//           semihosting     somebody keeps our files and wants an exit code
//           profile         also say what each task took (board/bare/profile.h)
//           group.name=X    sets a parameter, as --set of pirvs run does (pirvs params --all)
//           link            also says the poses in MAVLink, on the console's line (robot_link.h)
//           bench           single kernels on two images of the recording instead (bench.h)
//           fault=KIND      null, stack, hang or assert: do that at a frame, to see the report
//           fault_at=N      at which (default 20); fault_core=N on that core, one at rest
// Out     Every pose on the console, "pose" and a line of TUM; trajectory.tum and timing.csv where
//         there are files, with fixes fused.tum, too; at the end counters, stacks and instructions.
// Errors  Exit code as pirvs run: 0 done, 1 tracking failed or was lost at the end, 2 bad input;
//         and 3, safe state after a fault.
#include <cstring>

#include "board/bare/bench.h"
#include "board/bare/board.h"
#include "board/bare/fault_injection.h"
#include "board/bare/pack_input.h"
#include "board/bare/pin_watch.h"
#include "board/bare/profile.h"
#include "board/bare/robot_link.h"
#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/api/cycles.h"
#include "bsp/api/storage.h"
#include "bsp/bare/boot.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/stacks.h"
#include "bsp/replay/pack.h"
#include "bsp/replay/sensors.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "modules/app/replay_pace.h"
#include "modules/output/pose_text.h"

namespace pirvs::board {
namespace {

constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitBadInput = 2;
constexpr int kCountersMax = 128;
constexpr int kMicros = 6;  // decimals of a second

App app;  // in the pools' memory, see linker/bare.ld

struct Run {
  bsp::Pack pack;
  bsp::File trajectory, timing, fused;
  bool has_files = false;
  bool write_failed = false;
  uint32_t frames = 0, poses = 0, fused_poses = 0;
  TimeNs fused_t = INT64_MIN;  // of the last one
  HealthState health = HealthState::kInitializing;
  FaultInjection fault;

  void write(bsp::File file, const TextWriter& line) {
    if (!has_files) return;
    if (bsp::storage_write(file, line.c_str(), line.size()) != Status::kOk) write_failed = true;
  }
};
Run run;

void say(TextWriter& line) {
  line.put('\n');
  bsp::console_write(line.c_str());
  line.clear();
}

void on_frame(void*, const FrameReport& report) {
  robot_link_frame(report.t);
  Text<256> line;
  if (report.has_pose) {
    put_tum(line, report.t, report.pose.state.T_WB);
    line.put('\n');
    bsp::console_write("pose ");
    bsp::console_write(line.c_str());
    run.write(run.trajectory, line);
    ++run.poses;
  }
  line.clear();
  line.number(report.t);
  for (const float ms : {report.image_ms, report.matching_ms, report.tracking_ms, report.mapping_ms,
                         report.end_to_end_ms}) {
    line.put(',').fixed(static_cast<double>(ms), 4);
  }
  line.put('\n');
  run.write(run.timing, line);
  run.health = report.pose.health;
  ++run.frames;
  run.fault.on_frame(run.frames);
}

// The first word on each time, which is causal: a fix that came late tells the newest time again.
void on_fused(void*, const FusedPose& pose) {
  if (pose.t <= run.fused_t) return;
  run.fused_t = pose.t;
  ++run.fused_poses;
  Text<256> line;
  put_tum(line, pose.t, pose.T_EB);
  line.put('\n');
  run.write(run.fused, line);
}

void on_health(void*, TimeNs t, HealthState state, const char* what) {
  robot_link_health(state, what);
  Text<128> line;
  line.put("health ").fixed(to_seconds(t), kMicros).put(' ').put(name(state)).put(", ").put(what);
  say(line);
}

// Fixes, each at its turn.
bool next_fix(void*, Arrival& out) {
  bsp::PackedFix fix;
  if (!run.pack.next_fix(fix)) return false;
  out = arrival_of(fix_of(fix));
  return true;
}

// Small decimal numbers of the command line; fallback if the word is missing or no number.
int number_argument(const char* word, int fallback) {
  char text[16];
  if (!bsp::boot_argument(word, text, sizeof text) || text[0] == 0) return fallback;
  int value = 0;
  for (const char* c = text; *c != 0; ++c) {
    if (*c < '0' || *c > '9' || value > 99'999) return -1;  // no number: out of every range
    value = 10 * value + (*c - '0');
  }
  return value;
}

// Every parameter of the command line by its full name. Each is repeated on the console, where one
// whose name was mistyped is missed.
bool set_parameters(AppParams& params) {
  bool good = true;
  for_each_group(params, [&](const char* group, const auto&, const auto& rows) {
    for (const auto& row : rows) {
      Text<64> word;
      word.put(group).put('.').put(row.name);
      char text[TextWriter::kNumber];
      if (!bsp::boot_argument(word.c_str(), text, sizeof text)) continue;
      const ParamAnswer answer = set_parameter(params, word.c_str(), text);
      good = good && answer.ok();
      Text<160> line;
      line.put("parameter ").put(word.c_str()).put(" = ").put(text).put(": ");
      line.put(name(answer.status));
      say(line);
    }
  });
  return good;
}

Status open_recording() {
  const bsp::Memory memory = bsp::boot_recording();
  Text<160> line;
  line.put("recording ").hex(reinterpret_cast<uint64_t>(memory.data)).put(", ");
  line.unsigned_number(memory.size).put(" bytes");
  const Status status = run.pack.open(memory.data, memory.size);
  if (status == Status::kOk) {
    line.put(", ").unsigned_number(run.pack.header().frame_count).put(" frames, ");
    line.unsigned_number(run.pack.header().imu_count).put(" IMU samples");
    const uint32_t fixes = run.pack.header().fix_count;
    if (fixes > 0) line.put(", ").unsigned_number(fixes).put(" fixes");
    for (int c = 0; c < kCamerasMax; ++c) {
      const Camera camera = run.pack.camera(c);
      if (!image_fits(camera.width, camera.height)) {
        line.put(": images larger than this image was built for");
        say(line);
        return Status::kBadData;
      }
    }
  } else {
    line.put(": ").put(name(status));
  }
  say(line);
  return status;
}

Status open_files() {
  if (!bsp::boot_argument("semihosting")) return Status::kOk;
  const Result<bsp::File> trajectory = bsp::storage_open("trajectory.tum");
  if (!trajectory.ok()) return trajectory.status();
  const Result<bsp::File> timing = bsp::storage_open("timing.csv");
  if (!timing.ok()) return timing.status();
  if (run.pack.header().fix_count > 0) {
    const Result<bsp::File> fused = bsp::storage_open("fused.tum");
    if (!fused.ok()) return fused.status();
    run.fused = fused.value();
  }
  run.trajectory = trajectory.value();
  run.timing = timing.value();
  run.has_files = true;
  Text<96> head;
  head.put("t_ns,image_ms,matching_ms,tracking_ms,mapping_ms,end_to_end_ms\n");
  run.write(run.timing, head);
  return Status::kOk;
}

void close_files() {
  if (!run.has_files) return;
  for (const bsp::File file : {run.trajectory, run.timing}) {
    if (bsp::storage_close(file) != Status::kOk) run.write_failed = true;
  }
  if (run.pack.header().fix_count == 0) return;
  if (bsp::storage_close(run.fused) != Status::kOk) run.write_failed = true;
}

// An emulator's cores take turns, an instruction a nanosecond: its budgets say nothing.
bool is_of_time(const char* counter) {
  for (const char* const prefix : {"overruns_", "slips_"}) {
    if (std::strncmp(counter, prefix, std::strlen(prefix)) == 0) return true;
  }
  return false;
}

void say_counters() {
  const bool emulated = !bsp::cycles_are_real();
  NamedValue values[kCountersMax];
  Text<128> line;
  const int count = app.counters(values, kCountersMax);
  for (int i = 0; i < count; ++i) {
    if (values[i].value == 0 || (emulated && is_of_time(values[i].name))) continue;
    line.put("counter ").put(values[i].name).put(' ').unsigned_number(values[i].value);
    say(line);
  }
}

void say_end(const CorePlan& plan, const bsp::Cycles& spent, TimeNs duration) {
  Text<192> line;
  for (int core = 0; core < plan.cores; ++core) {
    line.put("stack of core ").number(core).put(": ").unsigned_number(bsp::stack_used(core));
    line.put(" of ").unsigned_number(bsp::stack_of(core).size()).put(" bytes used");
    say(line);
  }
  line.put("run: ").unsigned_number(spent.cycles);
  line.put(bsp::cycles_are_real() ? " cycles of the processor, "
                                  : " emulated cycles (one an instruction, all cores), ");
  line.unsigned_number(spent.instructions).put(" instructions, ");
  line.fixed(to_seconds(duration), kMicros).put(" s");
  say(line);
  line.unsigned_number(run.frames).put(" frames, ").unsigned_number(run.poses).put(" poses, ");
  if (run.fused_poses > 0) line.unsigned_number(run.fused_poses).put(" on the Earth, ");
  line.put(name(run.health)).put(" at the end");
  say(line);
}

void say_bench(const BenchResult& result) {
  Text<160> line;
  line.put(result.name).put(' ').put(result.unit).put(' ').unsigned_number(result.units);
  line.put(" units ").unsigned_number(result.spent.cycles).put(" cycles ");
  line.unsigned_number(result.spent.instructions).put(" instructions");
  say(line);
}

// Two moments in motion, if the recording is long enough.
int bench() {
  constexpr uint32_t kMoving = 100;
  const uint32_t frames = run.pack.header().frame_count;
  if (frames < 2) {
    bsp::console_write("bench: the recording needs two frames\n");
    return kExitBadInput;
  }
  const uint32_t at = frames > kMoving + 1 ? kMoving : 0;
  bsp::console_write(bsp::cycles_are_real()
                         ? "bench: cycles counted by the processor (PMU)\n"
                         : "bench: cycles counted by an emulator: one an instruction\n");
  bench_kernels(run.pack.frame(at).image[0], run.pack.frame(at + 1).image[0], say_bench);
  return kExitDone;
}

}  // namespace
}  // namespace pirvs::board

namespace pirvs {

using namespace board;

int application() {
  Text<128> line;
  line.put("\nPIRVS on ").put(bsp::kMachine.name).put(", ").number(kCores).put(" cores, version ");
  line.put(kVersion);
  say(line);
  if (pin_watch_wanted()) return pin_watch();
  if (!run.fault.configure()) {
    bsp::console_write("fault=: null, stack, hang or assert\n");
    return kExitBadInput;
  }
  AppParams params;
  if (!set_parameters(params)) return kExitBadInput;
  if (open_recording() != Status::kOk) return kExitBadInput;
  if (bsp::boot_argument("bench")) return bench();
  const int cores = number_argument("cores", kCores);
  if (cores < 1 || cores > kCores) {
    line.put("cores=: 1 to ").number(kCores);
    say(line);
    return kExitBadInput;
  }
  if (const Status status = open_files(); status != Status::kOk) {
    line.put("no file for the trajectory: ").put(name(status));
    say(line);
    return kExitBadInput;
  }
  char pace_text[8] = "";
  const bool free = bsp::boot_argument("pace", pace_text, sizeof pace_text) &&
                    std::strcmp(pace_text, "free") == 0;
  bsp::play(run.pack.source(), bsp::ReplayPace::kFast);
  AppSinks sinks;
  sinks.frame = on_frame;
  sinks.health = on_health;
  sinks.fused = on_fused;
  sinks.answer = [](void*, const Answer& answer) { robot_link_answer(answer); };
  const Calibration calibration = calibration_of(run.pack);
  app.configure(calibration, params, sinks);
  app.replay_inbox({nullptr, next_fix});
  app.pace(free && cores > 1 ? fast_may_go_on : lockstep_may_go_on);
  const bool profiled = bsp::boot_argument("profile");
  if (profiled) profile_start();
  const bsp::Cycles before = bsp::read_cycles();
  const TimeNs begin = bsp::now();
  const bool linked =
      bsp::boot_argument("link") && robot_link_open(app, calibration.imu) == Status::kOk;
  const Drive drive = cores == 1 ? Drive::kLockstep : Drive::kTimed;
  const AfterStep after_step = {nullptr, linked ? robot_link_poll : nullptr};
  const Status status = app.run(kPlans[cores - 1], drive, after_step);
  robot_link_close();
  const bsp::Cycles after = bsp::read_cycles();
  const TimeNs end = bsp::now();
  close_files();
  say_counters();
  if (profiled) profile_say(run.frames);
  say_end(kPlans[cores - 1],
          {after.cycles - before.cycles, after.instructions - before.instructions}, end - begin);
  if (run.write_failed) bsp::console_write("the trajectory could not be written\n");
  const bool whole = run.frames > 0 && run.health != HealthState::kLost;
  return status == Status::kOk && whole && !run.write_failed ? kExitDone : kExitFailed;
}

}  // namespace pirvs
