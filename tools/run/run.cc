// `pirvs run SEQ --out DIR`: the whole stack on a recording; `pirvs params`: its parameters.
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "board/host/board.h"
#include "bsp/api/clock.h"
#include "bsp/linux/storage.h"
#include "core/base/version.h"
#include "core/trace/trace.h"
#include "tools/cli/command.h"
#include "tools/cli/command_line.h"
#include "tools/cli/progress.h"
#include "tools/cli/stop.h"
#include "tools/convert/writers.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording_options.h"
#include "tools/info/image_turn.h"
#include "tools/info/imu_sense.h"
#include "tools/map/map_files.h"
#include "tools/report/report.h"
#include "tools/run/feed.h"
#include "tools/run/files.h"
#include "tools/run/parameters.h"
#include "tools/run/playback.h"
#include "tools/run/robot_output.h"
#include "tools/run/run_mcap.h"
#include "tools/run/run_viewed.h"
#include "tools/run/trace_file.h"
#include "tools/view/recorded_page.h"
#include "tools/view/replay_view.h"
#include "tools/view/run_view.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string sequence;
  std::string out;
  RecordingOptions recording;
  bool real_time = false;
  int cores = 1;
  bool lockstep = false;
  int mapping_lag = -1;
  double camera_latency_ms = 0;
  bool trace = false, force = false, mcap = false;
  std::vector<std::string> set;
  std::vector<std::string> faults;
  std::string record;
  std::string save_map, load_map, map_mode = "extend";
  std::string estimate;
  std::string mavlink;
  std::vector<std::string> mavlink_set;
  bool shown = false;
  std::string files = ".";  // folder of `map save` and `map load`, without --record
  ViewOptions shown_at;
};

App app;  // static memory, as on the device

// The signal that asked for an end, or 0. The second one ends at once. Whoever waits after the run
// has to know as well: it may come when the run has just ended.
volatile std::sig_atomic_t stopped_by = 0;

void stop_by_hand(int signal) {
  stopped_by = stop_wanted = signal;
  std::signal(signal, SIG_DFL);
}

// With *.mcap the recorder writes a folder that becomes one.
bool records_mcap(const std::string& record) {
  return std::filesystem::path(record).extension() == ".mcap";
}

std::string record_folder(const std::string& record) {
  return records_mcap(record) ? record + ".folder" : record;
}

void finish_record(const std::string& record) {
  if (!records_mcap(record)) return;
  InputLog log;
  write_mcap(
      open_recording(record_folder(record), {}), record, [](size_t) {}, log);
  print_notes(log);
  std::error_code error;
  std::filesystem::remove_all(record_folder(record), error);
}

void prepare_record(const std::string& record, const std::string& folder) {
  std::error_code error;
  if (records_mcap(record) && std::filesystem::exists(record)) {
    throw InputError("is there already", record, "choose another --record");
  }
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_empty(folder, error)) {
    throw InputError("not an empty folder", folder, "choose another --record");
  }
  bsp::set_storage_directory(folder.c_str());
}

void load_map(const std::string& file) {
  if (file.empty()) return;
  read_map_file(file, [](const MapSource& from) { return app.load_map(from); });
}

void print_result(const Options& options, const RunLog& log, const RunResult& r) {
  std::printf("%zu frames, %.1f s: %zu tracked, %zu lost, %zu before the start, %zu dropped\n",
              r.frames_in, r.duration_s, r.frames_tracked, r.frames_lost, r.frames_before_start,
              r.frames_dropped);
  std::printf("CPU per stereo frame [ms]");
  for (size_t i = 0; i < kTimingColumns.size(); ++i) {
    std::printf("  %s %.2f", kTimingColumns[i].label, r.timing[i].mean);
  }
  std::printf("  (p99 %.2f)\n", r.timing.back().p99);
  if (r.evaluation.ok) std::printf("%s\n", to_line(r.evaluation).c_str());
  for (const std::string& news : log.calibration_news) {
    if (!news.empty()) std::printf("%s\n", news.c_str());
  }
  if (!options.estimate.empty()) {
    std::printf("the cameras' offset was corrected by %.2f ms (sigma %.2f)\n",
                1e3 * to_seconds(log.camera_correction), 1e3 * log.calibration.time_sigma_s);
  }
  if (!options.load_map.empty() && r.localised_after_s < 0) {
    std::printf("not localised in %s: poses stand in a frame of their own\n",
                options.load_map.c_str());
  } else if (!options.load_map.empty()) {
    std::printf("localised in %s after %.2f s\n", options.load_map.c_str(), r.localised_after_s);
  }
  const FusedResult& fused = r.fused_result;
  if (fused.ok) {
    std::printf("with GNSS: ATE %.4f m, not aligned (fixes alone %.3f m), heading %.2f deg\n",
                fused.ate_rmse_m, fused.fixes_rmse_m, fused.heading_rmse_deg);
  }
  if (!options.out.empty()) std::printf("written to %s\n", options.out.c_str());
}

// Why a run did not end as it should, if it did not. Returns the exit status.
int tell_end(const Recording& recording, const RunResult& result) {
  if (stopped_by != 0) {
    std::fprintf(stderr, "pirvs: stopped by hand: the results are of what was run\n");
    return kExitSignal + stopped_by;
  }
  if (!result.done) {
    for (const std::string& why : faults_of(compare_turns(recording))) {
      std::fprintf(stderr, "pirvs: %s\n", why.c_str());
    }
    const bool told = !result.verdict.empty();
    std::fprintf(stderr, "pirvs: %s\n", told ? result.verdict.c_str() : "the run was cut off");
  }
  return result.exit_status();
}

// As a page; empty where that is not built, or there is no pose to show.
std::string viewer_of(const std::string& folder) {
  try {
    ViewScene scene;
    show_run(scene, folder, OutputFolder::kPart);
    return recorded_page(scene.all());
  } catch (const InputError&) {
    return "";
  }
}

void write_results(OutputFolder& out, const Options& options, const RunInfo& info,
                   const Recording& recording, const RunLog& log, const RunResult& result,
                   const std::vector<Count>& rejected) {
  write_run_files(out, info, recording, log, result, rejected);
  const std::string viewer = viewer_of(options.out);
  out.write("report.html", make_report(info, recording, log, result, rejected, viewer));
  if (options.trace) out.write("trace.json", trace_json());
  if (options.mcap) out.write("run.mcap", run_mcap(recording, log, result));
  out.commit();
}

AppParams params_of(const Options& options) {
  AppParams params;
  for (const std::string& assignment : options.set) set_parameter(params, assignment);
  if (!options.estimate.empty()) params.tracking.tracker.estimate_time = 1;
  if (options.map_mode == "localise") params.mapping.extend_map = 0;
  return params;
}

// Refuses what no start can come of: units that are none of ours.
Recording open_sound(const Options& options) {
  Recording recording = open_recording(options.sequence, options.recording);
  print_notes(recording);
  const ImuFault fault = find_imu_fault(recording.imu);
  if (!fault.what.empty()) throw InputError(fault.what, options.sequence, fault.what_to_do);
  return recording;
}

Playback playback_of(const Options& options) {
  if (options.real_time) return Playback::kRealTime;
  return options.lockstep ? Playback::kLockstep : Playback::kFast;
}

// `view`: null: nobody looks.
int run(const Options& options, const std::string& command, View* view) {
  const AppParams params = params_of(options);
  std::vector<Fault> faults;
  for (const std::string& spec : options.faults) faults.push_back(parse_fault(spec));
  const Recording recording = open_sound(options);
  std::optional<OutputFolder> out;
  if (!options.out.empty()) out.emplace(options.out, options.force);
  const std::string recorded_to = record_folder(options.record);
  if (!options.record.empty()) prepare_record(options.record, recorded_to);
  RunLog log(recording.frames.size());
  std::optional<RobotOutput> robot;
  if (!options.mavlink.empty()) {
    robot.emplace(options.mavlink, options.mavlink_set, options.real_time);
    log.listeners.push_back(&*robot);
  }
  std::optional<ReplayView> shown;
  const std::string& maps = options.record.empty() ? options.files : recorded_to;
  if (view != nullptr) log.listeners.push_back(&shown.emplace(*view, recording, maps));
  RunInfo info = {command, options.sequence, kVersion, options.cores, {}};
  std::vector<Count> rejected;
  const auto begin = std::chrono::steady_clock::now();
  Status status = Status::kOk;
  {
    Progress progress("running", recording.frames.size());
    Feed feed(
        recording, faults, [&progress](size_t played) { progress.update(played); },
        from_seconds(options.camera_latency_ms * 1e-3));
    stopped_by = 0;
    feed.end_when(&stopped_by);
    std::signal(SIGINT, stop_by_hand);
    std::signal(SIGTERM, stop_by_hand);
    if (options.trace) trace_start(bsp::now);
    app.configure(recording.calibration, params, log.sinks());
    load_map(options.load_map);
    if (robot) robot->open(app, recording.calibration.imu);
    if (shown) shown->open(app);
    if (shown && !options.load_map.empty()) shown->show_map_later(options.load_map);
    app.replay_inbox(options.real_time ? feed.others() : feed.inbox());
    if (!options.real_time && options.mapping_lag < 0) app.replay_maps(feed.maps());
    if (!options.record.empty() && app.record() != Status::kOk) {
      throw InputError("cannot record", options.record, "check space and permissions");
    }
    if (options.mapping_lag >= 0) app.delay_mapping(options.mapping_lag);
    const Playback playback = playback_of(options);
    if (options.real_time) log.attach(app, recording.imu.size());
    status = play(app, feed.source(), board::kPlans[options.cores - 1], playback, [&] {
      log.take_poses(app);
      if (robot) robot->after_step();
    });
    if (robot) robot->close();
    if (shown) shown->close(stopped_by != 0 ? "stopped by hand" : "the recording has ended");
    rejected = feed.rejected();
    info.faults = feed.faults_applied();
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  log.finish(app);
  if (robot) robot->add_counters(log.counters);
  RunResult result = make_result(recording, log, status);
  result.wall_s = wall.count();
  if (out) write_results(*out, options, info, recording, log, result, rejected);
  if (!options.record.empty()) finish_record(options.record);
  if (!options.save_map.empty()) write_map_file(options.save_map, app.map());
  print_result(options, log, result);
  return tell_end(recording, result);
}

void add_map_options(CLI::App& app, Options& o) {
  app.add_option("--save-map", o.save_map,
                 "FILE, the map at the end of the run, to be localised in later (docs/maps.md)");
  auto* const load_map =
      app.add_option("--load-map", o.load_map,
                     "FILE, the map of an earlier run: poses stand in its frame once a place of it "
                     "is recognised")
          ->check(CLI::ExistingFile);
  app.add_option("--map-mode", o.map_mode,
                 "extend: the loaded map grows; localise: it stays as it is")
      ->check(CLI::IsMember({"extend", "localise"}))
      ->capture_default_str()
      ->needs(load_map);
}

std::function<int()> declare_run(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option(
         "SEQ", o->sequence,
         "recording: an ASL/EuRoC folder, a ROS bag, a rosbag2 folder, MCAP, or a packed file")
      ->required();
  app.add_option("--out", o->out, "folder for the results")->required();
  add_recording_options(app, o->recording);
  app.add_flag("--force", o->force, "replace the results of an earlier run in --out");
  app.add_option(
      "--gnss", o->recording.gnss,
      "fixes of a GNSS receiver, instead of the recording's own: .csv as in gnss0, .ubx, "
      ".nmea, or RTKLIB's .pos");
  app.add_option("--wheels", o->recording.wheels,
                 "what the wheels told, instead of the recording's own: a table as in wheel0, its "
                 "sensor.yaml beside it");
  auto* const real_time =
      app.add_flag("--realtime", o->real_time, "play at the pace of the recording");
  app.add_option("--cores", o->cores,
                 "threads; with 1 the same input gives the same output, byte for byte")
      ->capture_default_str()
      ->check(CLI::Range(1, board::kCores));
  app.add_flag("--lockstep", o->lockstep,
               "with several --cores: wait for mapping, so that the output is that of one core")
      ->excludes(real_time);
  app.add_option("--mapping-lag", o->mapping_lag,
                 "delay each result of mapping by exactly this many frames, for tests")
      ->check(CLI::Range(0, MapGate::kLagMax))
      ->excludes(real_time);
  app.add_option("--camera-latency", o->camera_latency_ms,
                 "MS, deliver each frame this much later than the IMU samples of its time")
      ->check(CLI::Range(0.0, 1000.0));
  app.add_flag("--trace", o->trace,
               "also write trace.json: when each task ran, in the last seconds");
  app.add_flag("--mcap", o->mcap,
               "also write run.mcap: poses, points, health, images, for Foxglove and rosbag2");
  app.add_option("--set", o->set, "name=value, a parameter (pirvs params --all lists them)")
      ->allow_extra_args(false);
  app.add_option("--estimate", o->estimate,
                 "time: the cameras' time offset is estimated and corrected while tracking")
      ->check(CLI::IsMember({"time"}));
  app.add_option("--fault", o->faults, "SPEC, inject a fault into the input; repeatable, see below")
      ->allow_extra_args(false);
  app.add_option("--record", o->record,
                 "also write the input, with its injected faults, as an ASL folder, or as *.mcap");
  add_map_options(app, *o);
  auto* const mavlink = app.add_option(
      "--mavlink", o->mavlink,
      "udp:HOST:PORT or a file, the poses as an autopilot gets them (docs/integration.md)");
  app.add_option("--mavlink-set", o->mavlink_set,
                 "name=value, a key of the link: rate_hz, frame, messages, system, mounting_deg")
      ->allow_extra_args(false)
      ->needs(mavlink);
  auto* const shown = app.add_flag("--view", o->shown, "also show it as a page (docs/view.md)");
  shown->needs(real_time);
  for (CLI::Option* option : add_view_options(app, o->shown_at)) option->needs(shown);
  app.footer(fault_help());
  return [o, &app] {
    std::optional<View> view;
    if (o->shown) view.emplace(o->shown_at);
    return run(*o, command_line(app), view ? &*view : nullptr);
  };
}

std::function<int()> declare_params(CLI::App& app) {
  const auto all = std::make_shared<bool>(false);
  app.add_flag("--all", *all, "also those for experts: the estimator's noise model and limits");
  return [all] {
    std::printf("%s", list_parameters(AppParams{}, *all).c_str());
    return kExitDone;
  };
}

}  // namespace

int run_viewed(View& view, const std::string& sequence, const ViewedRun& how) {
  Options options;
  options.sequence = sequence;
  options.recording = how.recording;
  options.real_time = true;
  options.cores = how.cores;
  options.set = how.set;
  options.load_map = how.load_map;
  if (!how.files.empty()) options.files = how.files;
  bsp::set_storage_directory(options.files.c_str());
  return run(options, "pirvs view", &view);
}

const Command kRunCommand = {"run", "Run SLAM on a recording", declare_run};
const Command kParamsCommand = {"params", "List the parameters that --set can change",
                                declare_params};

}  // namespace pirvs::tools
