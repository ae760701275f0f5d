// `pirvs run SEQ --out DIR`: the whole stack on a recording; `pirvs params`: its parameters.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "board/host/board.h"
#include "bsp/api/clock.h"
#include "bsp/replay/replay.h"
#include "core/trace/trace.h"
#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"
#include "tools/report/report.h"
#include "tools/run/files.h"
#include "tools/run/parameters.h"
#include "tools/run/trace_file.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string sequence;
  std::string out;
  RecordingOptions recording;
  bool real_time = false;
  int cores = 1;
  bool trace = false;
  std::vector<std::string> set;
};

// The recording as bsp/replay wants it, and the progress bar that its frames drive.
struct Feed {
  const Recording& recording;
  Player player;
  Progress progress;
  size_t imu_at = 0;

  explicit Feed(const Recording& r)
      : recording(r), player(r), progress("running", r.frames.size()) {}

  static bool next_imu(void* context, ImuSample& out) {
    Feed& feed = *static_cast<Feed*>(context);
    if (feed.imu_at == feed.recording.imu.size()) return false;
    out = feed.recording.imu[feed.imu_at++];
    return true;
  }
  static bool next_frame(void* context, StereoFrame& out) {
    const StereoFrame* const frame = static_cast<Feed*>(context)->player.front();
    if (frame) out = *frame;
    return frame != nullptr;
  }
  static void release_frame(void* context) {
    Feed& feed = *static_cast<Feed*>(context);
    feed.player.pop();
    feed.progress.update(feed.player.frames_played());
  }
};

App app;  // static memory, as on the device

void print_result(const Options& options, const RunResult& r) {
  std::printf("%zu frames, %.1f s: %zu tracked, %zu lost, %zu before the start, %zu dropped\n",
              r.frames_in, r.duration_s, r.frames_tracked, r.frames_lost, r.frames_before_start,
              r.frames_dropped);
  std::printf("CPU per stereo frame [ms]");
  for (size_t i = 0; i < kTimingColumns.size(); ++i) {
    std::printf("  %s %.2f", kTimingColumns[i].label, r.timing[i].mean);
  }
  std::printf("  (p99 %.2f)\n", r.timing.back().p99);
  if (r.evaluation.ok) std::printf("%s\n", to_line(r.evaluation).c_str());
  std::printf("written to %s\n", options.out.c_str());
}

int run(const Options& options, const std::string& command) {
  AppParams params;
  for (const std::string& assignment : options.set) set_parameter(params, assignment);
  const Recording recording = open_recording(options.sequence, options.recording);
  if (recording.calibration.cameras < 2) {
    throw InputError("only one camera", options.sequence,
                     "starting needs metric depth from a stereo pair: record cam0 and cam1");
  }
  make_output_folder(options.out);
  RunLog log(recording.frames.size());
  std::vector<Count> rejected;
  const auto begin = std::chrono::steady_clock::now();
  Status status = Status::kOk;
  {
    Feed feed(recording);
    bsp::replay_start({&feed, Feed::next_imu, Feed::next_frame, Feed::release_frame},
                      options.real_time ? bsp::ReplayPace::kRealTime : bsp::ReplayPace::kFast);
    if (options.trace) trace_start(bsp::now);
    app.configure(recording.calibration, params, log.sinks());
    status = app.run(board::kPlans[options.cores - 1],
                     options.real_time ? Pace::kSensors : Pace::kAsWeGo);
    rejected = feed.player.rejected();
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  log.finish(app);
  RunResult result = make_result(recording, log, status);
  result.wall_s = wall.count();
  const RunInfo info = {command, options.sequence, source_revision(), options.cores};
  write_run_files(options.out, info, recording, log, result, rejected);
  write_file(options.out + "/report.html", make_report(info, recording, log, result, rejected));
  if (options.trace) write_trace(options.out + "/trace.json");
  print_result(options, result);
  if (!result.done) std::fprintf(stderr, "pirvs: tracking was lost at the end\n");
  return result.exit_status();
}

std::string joined(const CLI::App& app) {
  std::string out = "pirvs run";
  for (const CLI::Option* option : app.parse_order()) {
    const std::string name = option->get_positional() ? "" : " " + option->get_name();
    out += name;
    for (const std::string& value : option->results()) {
      if (option->get_expected_max() > 0) out += " " + value;
    }
  }
  return out;
}

std::function<int()> declare_run(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "recording: an ASL/EuRoC folder")->required();
  app.add_option("--out", o->out, "folder for the results")->required();
  app.add_option("--calib", o->recording.calibration, "Kalibr camchain-imucam.yaml to use instead");
  app.add_option("--start", o->recording.start_s, "skip this many seconds")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--duration", o->recording.duration_s, "stop after this many seconds")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--realtime", o->real_time, "play at the pace of the recording");
  app.add_option("--cores", o->cores, "threads; 1: lockstep, same input, same bytes")
      ->capture_default_str()
      ->check(CLI::Range(1, board::kCores));
  app.add_flag("--trace", o->trace, "also write trace.json: every step of the last seconds");
  app.add_option("--set", o->set, "name=value, a parameter (pirvs params lists them)")
      ->allow_extra_args(false);
  return [o, &app] { return run(*o, joined(app)); };
}

std::function<int()> declare_params(CLI::App&) {
  return [] {
    std::printf("%s", list_parameters(AppParams{}).c_str());
    return kExitDone;
  };
}

}  // namespace

const Command kRunCommand = {"run", "Run SLAM on a recording", declare_run};
const Command kParamsCommand = {"params", "List the parameters that --set can change",
                                declare_params};

}  // namespace pirvs::tools
