// pirvsd: the whole stack on live sensors, as a program of Linux. See kHelp, and docs/device.md.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "board/linux/board.h"
#include "board/linux/heap_watch.h"
#include "board/linux/image_share.h"
#include "board/linux/pins.h"
#include "board/linux/pose_output.h"
#include "board/linux/recordings.h"
#include "board/linux/robot_link.h"
#include "board/linux/serial_link.h"
#include "board/linux/settings.h"
#include "board/linux/stream_output.h"
#include "board/linux/watchdog.h"
#include "board/linux/wiring.h"
#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/api/events.h"
#include "bsp/linux/cores.h"
#include "bsp/linux/events.h"
#include "bsp/linux/text_file.h"
#include "core/base/text.h"
#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"

namespace pirvs::board {
namespace {

constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitBadInput = 2;
constexpr int kCountersMax = 256;

constexpr const char* kHelp =
    "pirvsd: tracks a stereo camera and an IMU, and gives out where they are.\n"
    "usage: pirvsd [CONFIG] [--camera LEFT[,RIGHT]] [--imu DEVICE] [--calibration FILE]\n"
    "              [--set KEY=VALUE]...\n"
    "  CONFIG         a file of `key = value`; what follows it on the command line wins\n"
    "  --camera       nodes of V4L2, /dev/video0,/dev/video2\n"
    "  --imu          iio:0, or by the name of its driver, iio:mpu6500; or icm20602:BUS\n"
    "  --calibration  written by `pirvs calibration`\n"
    "  --set          any key of the file, output.text=frames\n"
    "  --health-low   with CONFIG alone: drives HEALTH low and exits, after pirvsd was killed\n"
    "Poses come on standard output, one a line: t x y z qx qy qz qw health confidence.\n"
    "News of sensors and health come on standard error. SIGTERM and SIGINT end it in order.\n"
    "Exit status: 0 ended by a signal, 1 a core could not be started, 2 bad input.\n";

App app;
Settings settings;
PoseOutput poses;
Pins pins;
StreamOutput stream_output;
Watchdog watchdog;
Recordings recordings;
SerialLink serial;
RobotLink robot;
ImageShare images;
Calibration calibration;
char config_text[kSettingsTextMax];
char calibration_text[kCalibrationTextMax + kSettingsTextMax];

volatile sig_atomic_t stop_wanted = 0;

void on_signal(int) {
  stop_wanted = 1;
  bsp::wake(0);
}

void say(TextWriter& line) {
  line.put('\n');
  bsp::console_write(line.c_str());
  line.clear();
}

// pirvsd: where: what
void say(const char* where, const char* what) {
  Text<512> line;
  line.put("pirvsd: ").put(where).put(": ").put(what);
  say(line);
}

void on_news(void*, const char* device, const char* what) { say(device, what); }

void on_frame(void*, const FrameReport& report) { poses.frame(report); }

void on_answer(void*, const Answer& answer) {
  recordings.answer(answer);
  serial.answer(answer);
  robot.answer(answer);
}

TimeNs frame_taken_t = INT64_MIN / 2;  // on our clock

void on_frame_taken(const StereoFrame& frame) {
  frame_taken_t = bsp::now();
  watchdog.ready();
  pins.frame_taken(frame.t);
  stream_output.frame(frame);
  images.frame(frame);
}

void on_pose(const Pose& pose) {
  pins.pose(pose);
  stream_output.pose(pose);
}

void on_sync_in(void*, const SyncEvent& event) {
  poses.event(event);
  stream_output.event(event);
}

void on_pps(void*, const bsp::Pps& pps) { stream_output.pps(pps); }

void on_health(void*, TimeNs t, HealthState state, const char* what) {
  pins.health(state);
  stream_output.health(t, state, what);
  robot.health(state, what);
  constexpr int kMillis = 3;
  Text<192> line;
  line.put("pirvsd: ").fixed(to_seconds(t), kMillis).put(' ').put(name(state)).put(", ").put(what);
  say(line);
}

// A task that is late again and again: this machine is too slow for these sensors. While they are
// away it is those who look for them that take long.
void on_late(void*, TimeNs t, const LateTask& task) {
  constexpr TimeNs kAway_ns = 1'000'000'000;
  if (bsp::now() - frame_taken_t > kAway_ns) return;
  constexpr int kMillis = 3;
  Text<192> line;
  line.put("pirvsd: ").fixed(to_seconds(t), kMillis).put(' ').put(task.name).put(" is late: ");
  line.unsigned_number(task.overruns).put(" steps over budget, ");
  line.unsigned_number(task.slips).put(" asked too late");
  say(line);
}

// ---- input -------------------------------------------------------------------------------------

// The whole file as text; says why not.
bool read_file(const char* path, char* out, size_t max, std::string_view& text) {
  const char* const why = bsp::read_text_file(path, out, max, text);
  if (why != nullptr) say(path, why);
  return why == nullptr;
}

bool say_fault(const char* path, const ConfigFault& fault) {
  Text<512> line;
  line.put("pirvsd: ");
  put_fault(line, path, fault);
  say(line);
  return false;
}

bool take_setting(std::string_view key, std::string_view value) {
  const char* const why = set_setting(settings, key, value);
  return why == nullptr || say_fault("command line", {0, why, key});
}

bool take_cameras(std::string_view value) {
  const size_t comma = value.find(',');
  const size_t end = comma == std::string_view::npos ? value.size() : comma;
  if (!take_setting("camera.left", {value.data(), end})) return false;
  if (end == value.size()) return true;
  return take_setting("camera.right", {value.data() + end + 1, value.size() - end - 1});
}

bool take_assignment(std::string_view text) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return say_fault("command line", {0, "--set wants KEY=VALUE", text});
  }
  return take_setting({text.data(), equals}, {text.data() + equals + 1, text.size() - equals - 1});
}

bool take_option(const char* option, const char* value) {
  if (std::strcmp(option, "--camera") == 0) return take_cameras(value);
  if (std::strcmp(option, "--imu") == 0) return take_setting("imu", value);
  if (std::strcmp(option, "--calibration") == 0) return take_setting("calibration", value);
  if (std::strcmp(option, "--set") == 0) return take_assignment(value);
  return say_fault("command line", {0, "no such option, see --help", option});
}

// A path of the file is meant from where the file lies.
void from_folder_of(const char* file, SettingText& path) {
  const char* const slash = std::strrchr(file, '/');
  if (path.text[0] == 0 || path.text[0] == '/' || slash == nullptr) return;
  Text<sizeof(path.text)> joined;
  for (const char* c = file; c <= slash; ++c) joined.put(*c);
  joined.put(path.text);
  if (!joined.full()) std::memcpy(path.text, joined.c_str(), joined.size() + 1);
}

bool read_config(const char* path) {
  std::string_view text;
  if (!read_file(path, config_text, sizeof config_text, text)) return false;
  if (const ConfigFault fault = read_settings(text, settings)) return say_fault(path, fault);
  from_folder_of(path, settings.calibration);
  return true;
}

bool read_command_line(int argc, char** argv) {
  int at = 1;
  if (at < argc && argv[at][0] != '-' && !read_config(argv[at++])) return false;
  for (; at < argc; at += 2) {
    if (at + 1 == argc) {
      return say_fault("command line", {0, "a value is missing, see --help", argv[at]});
    }
    if (!take_option(argv[at], argv[at + 1])) return false;
  }
  if (kBoard.media == nullptr && isp_of(settings.camera[0]) >= 0) {
    return say_fault("settings", {0, "this board has no ISPs, name a video node", "camera.left"});
  }
  finish_settings(settings);
  const ConfigFault fault = find_missing(settings);
  return !fault || say_fault("settings", fault);
}

bool read_device_calibration() {
  const char* const path = settings.calibration.text;
  std::string_view text;
  if (!read_file(path, calibration_text, sizeof calibration_text, text)) return false;
  if (const ConfigFault fault = read_calibration(text, calibration)) return say_fault(path, fault);
  if (settings.camera[1].text[0] == 0 && calibration.cameras == 2) {
    say(settings.camera[0].text, "no camera.right: tracking with the left one alone");
    calibration.cameras = 1;
  }
  if (const CalibrationFault fault = find_fault(calibration)) {
    Text<512> line;
    line.put("pirvsd: ").put(path).put(", ").put(fault.where).put(": ").put(fault.what);
    line.put(": ").put(fault.what_to_do);
    say(line);
    return false;
  }
  return true;
}

// ---- the machine -------------------------------------------------------------------------------

void take_the_machine() {
  if (!settings.realtime) return;
  bsp::ask_not_to_be_killed();
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    say("memory not locked", "it needs CAP_IPC_LOCK or RLIMIT_MEMLOCK");
  }
  for (int core = 0; core < bsp::kCoresMax; ++core) bsp::set_core(core, kBoard.cores[core]);
}

void obey_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaction(number, &action, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

SensorSetup sensors() {
  SensorSetup out;
  out.stereo = settings.stereo;
  out.stereo.cameras = calibration.cameras;
  for (int c = 0; c < calibration.cameras; ++c) {
    bsp::V4l2Setup& camera = out.stereo.camera[c];
    camera.path = settings.camera[c].text;
    camera.event_path = settings.camera_events[c].text;
    camera.controls.sensor = settings.camera_sensor[c].text;
    camera.jpeg = kBoard.jpeg;
    camera.width = calibration.camera[c].width;
    camera.height = calibration.camera[c].height;
    if (isp_of(settings.camera[c]) < 0) continue;
    camera.media.table = kBoard.media;
    camera.media.camera = isp_of(settings.camera[c]);
    camera.clock = bsp::StampClock::kBoottime;  // rkisp1's, whatever its flags say
  }
  out.iio = settings.iio;
  out.iio.device = settings.imu.text;
  out.imu_is_on_i2c = settings.imu_is_on_i2c;
  out.i2c_imu = settings.i2c_imu;
  out.i2c_imu.device = settings.imu.text;
  out.i2c_imu.data_ready = settings.imu_data_ready.text;
  out.i2c_imu.urgent = settings.realtime;
  out.news.tell = on_news;
  out.core = kBoard.plan.door;
  out.frame_taken = on_frame_taken;
  return out;
}

// What a pin lacks is told, and the device runs without it.
void open_pins() {
  PinSinks sinks;
  sinks.deliver = [](void*, const Arrival& arrival) { return app.deliver(arrival); };
  sinks.event = on_sync_in;
  sinks.pps = on_pps;
  pins.open(settings.pins, settings.realtime, {nullptr, on_news}, sinks);
  if (pins.sync_in_fd() >= 0) (void)bsp::watch_fd(0, pins.sync_in_fd());
}

void close_pins() {
  if (pins.sync_in_fd() >= 0) bsp::forget_fd(0, pins.sync_in_fd());
  pins.close();
}

// Without it there would be no images.
bool start_cameras_trigger() {
  TriggerSetup setup = settings.trigger;
  setup.pin = settings.pins.trigger.text;
  setup.urgent = settings.realtime;
  const char* const why = start_trigger(setup);
  if (why != nullptr) say(setup.pin[0] != 0 ? setup.pin : "trigger", why);
  return why == nullptr;
}

bool start_record() {
  const char* const why = recordings.start(settings, app);
  if (why != nullptr) say(folder_of(settings), why);
  return why == nullptr;
}

// ---- the end -----------------------------------------------------------------------------------

// Every counter of the device, `camera.left.lost` and so on.
void for_each_counter_of_device(VisitValue visit, void* context) {
  struct Named {
    VisitValue visit;
    void* context;
    void operator()(const char* device, const char* name, uint64_t value) const {
      Text<96> whole;
      whole.put(device).put(device[0] != 0 ? "." : "").put(name);
      visit(context, whole.c_str(), value);
    }
  };
  static Named named;
  named = {visit, context};
  NamedValue values[kCountersMax];
  const int count = app.counters(values, kCountersMax);
  for (int i = 0; i < count; ++i) named("", values[i].name, values[i].value);
  for_each_sensor_counter(
      [](const char* device, const char* name, uint32_t value) { named(device, name, value); });
  for_each_counter(pins.counters(), kPinCounterRows,
                   [](const char* name, uint32_t value) { named("pin", name, value); });
  named("pin", "sync_out_pulses", pins.pulses());
  named("pin", "sync_out_left_out", pins.pulses_left_out());
  for_each_counter(stream_output.counters(), kStreamCounterRows,
                   [](const char* name, uint32_t value) { named("stream", name, value); });
  for_each_counter(serial.counters(), kSerialLinkRows,
                   [](const char* name, uint32_t value) { named("serial", name, value); });
  for_each_counter(images.counters(), kImageShareRows,
                   [](const char* name, uint32_t value) { named("images", name, value); });
  robot.for_each_counter([](const char* name, uint32_t value) { named("link", name, value); });
  named("output", "lines", poses.written());
  named("output", "datagrams", poses.sent());
  named("output", "dropped", poses.dropped());
  named("disk", "flushes", recordings.flushes());
  named("heap", "calls", heap::calls());
  named("heap", "calls_after_start", heap::calls_after_start());
}

void say_counter(void*, const char* name, uint64_t value) {
  if (value == 0) return;
  Text<160> line;
  line.put("counter ").put(name).put(' ').unsigned_number(value);
  say(line);
}

void say_latency(const char* name, const LatencySummary& summary) {
  constexpr int kDecimals = 3;
  if (summary.count == 0) return;
  Text<160> line;
  line.put("latency ").put(name).put(", ms: median ").fixed(summary.median_ms, kDecimals);
  line.put(", p99 ").fixed(summary.p99_ms, kDecimals).put(", max ");
  line.fixed(summary.max_ms, kDecimals).put(", of ").unsigned_number(summary.count);
  say(line);
}

void say_counters() {
  for_each_counter_of_device(say_counter, nullptr);
  say_latency("imu_to_pose", app.latency().imu_to_pose.summary());
  say_latency("exposure_to_fused", app.latency().exposure_to_fused.summary());
}

// ` name=value` of what is not zero.
void put_counters(void*, TextWriter& out) {
  const auto put = [](void* to, const char* name, uint64_t value) {
    if (value == 0) return;
    static_cast<TextWriter*>(to)->put(' ').put(name).put('=').unsigned_number(value);
  };
  for_each_counter_of_device(put, &out);
}

void start_links() {
  const auto command = [](void*, const Command& command) { return app.command(command); };
  serial.configure(settings.serial.text, {nullptr, command, put_counters});
  if (serial.wanted()) poses.also([](const TextWriter& line) { serial.pose(line); });
  if (settings.link.is_wanted()) {
    const char* why = robot.open(settings.link, calibration.imu, app, bsp::now);
    if (why == nullptr) why = robot.start_thread();
    if (why != nullptr) say("link", why);
  }
  if (settings.images.text[0] == 0) return;
  const Camera& camera = calibration.camera[0];
  const Status status =
      images.open(settings.images.text, calibration.cameras, camera.width, camera.height);
  if (status != Status::kOk) say(settings.images.text, "images cannot be given out there");
}

void end_links() {
  serial.close();
  robot.close();
  images.close();
}

void stop_when_wanted(bool& asked) {
  if (stop_wanted == 0 || asked) return;
  Command stop;
  stop.kind = CommandKind::kStop;
  asked = app.command(stop).ok();
}

int run() {
  AppSinks sinks;
  sinks.frame = on_frame;
  sinks.health = on_health;
  sinks.late = on_late;
  sinks.answer = on_answer;
  sinks.new_recording = [](void*) { return recordings.next(); };
  app.configure(calibration, settings.params, sinks);
  app.set_clock(bsp::now);
  if (!start_record()) return kExitBadInput;
  if (poses.configure(settings, app.poses()) != Status::kOk) {
    say("output.poses", "no socket for the datagrams");
    return kExitBadInput;
  }
  if (!start_cameras_trigger()) return kExitBadInput;
  start_links();
  open_pins();
  if (const char* const why = watchdog.open(settings.watchdog.text, {nullptr, on_news})) {
    say(settings.watchdog.text, why);
  }
  if (settings.has_stream) {
    const char* const why = stream_output.open(settings.stream, app, for_each_counter_of_device);
    if (why != nullptr) say("output.stream", why);
  }
  wire_sensors(sensors());
  const bool started = app.start(kBoard.plan, Drive::kTimed) == Status::kOk;
  if (!started) say("cores", "a thread could not be started");
  if (const char* const why = bsp::core_refusals()) say(kBoard.name, why);
  heap::start_is_over();
  bool asked_to_stop = false;
  while (started && app.poll() != Status::kStale) {
    poses.send(on_pose);
    pins.poll();
    stream_output.poll();
    watchdog.poll();
    serial.poll(bsp::now());
    stop_when_wanted(asked_to_stop);
  }
  (void)app.finish();  // a run that never found a start is no failure of the program
  poses.send(on_pose);
  say_counters();
  end_links();
  poses.close();
  recordings.stop();
  close_pins();
  stream_output.close();
  watchdog.close();
  unwire_sensors();
  return started ? kExitDone : kExitFailed;
}

// A pin stays as it was when the program that drove it is killed.
int put_health_low(const char* config) {
  if (!read_config(config)) return kExitBadInput;
  const char* const pin = settings.pins.health.text;
  if (pin[0] == 0) return kExitDone;
  bsp::OutputPin health;
  const char* const why = health.open(pin, false, "pirvsd");
  if (why != nullptr) say(pin, why);
  return why == nullptr ? kExitDone : kExitFailed;
}

int main_of(int argc, char** argv) {
  if (argc > 1 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0)) {
    (void)!write(STDOUT_FILENO, kHelp, std::strlen(kHelp));
    return kExitDone;
  }
  if (argc == 3 && std::strcmp(argv[2], "--health-low") == 0) return put_health_low(argv[1]);
  if (!read_command_line(argc, argv) || !read_device_calibration()) return kExitBadInput;
  obey_signals();
  take_the_machine();
  return run();
}

}  // namespace
}  // namespace pirvs::board

int main(int argc, char** argv) { return pirvs::board::main_of(argc, argv); }
