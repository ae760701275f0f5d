// pirvsd: the whole stack on live sensors, as a program of Linux. See kHelp, and docs/device.md.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "board/linux/board.h"
#include "board/linux/gnss_receiver.h"
#include "board/linux/heap_watch.h"
#include "board/linux/image_share.h"
#include "board/linux/input.h"
#include "board/linux/machine_load.h"
#include "board/linux/pins.h"
#include "board/linux/pose_output.h"
#include "board/linux/recordings.h"
#include "board/linux/robot_link.h"
#include "board/linux/say.h"
#include "board/linux/serial_link.h"
#include "board/linux/settings.h"
#include "board/linux/stream_output.h"
#include "board/linux/watchdog.h"
#include "board/linux/wiring.h"
#include "bsp/api/clock.h"
#include "bsp/api/events.h"
#include "bsp/linux/cores.h"
#include "bsp/linux/events.h"
#include "core/base/text.h"
#include "core/base/version.h"

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
    "  --version      says it\n"
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
GnssReceiver gnss;
ImageShare images;
MachineLoad machine_load;
Calibration calibration;

volatile sig_atomic_t stop_wanted = 0;

void on_signal(int) {
  stop_wanted = 1;
  bsp::wake(0);
}

void on_news(void*, const char* device, const char* what) { say(device, what); }

void on_frame(void*, const FrameReport& report) { poses.frame(report); }

uint32_t map_ticket = 0;  // of the map at the start, plus 1

void load_map() {
  if (settings.map.text[0] == 0) return;
  Command load;
  load.kind = CommandKind::kLoadMap;
  std::memcpy(load.text, settings.map.text, std::strlen(settings.map.text));
  const Result<uint32_t> ticket = app.command(load);
  map_ticket = ticket.ok() ? ticket.value() + 1 : 0;
}

void on_answer(void*, const Answer& answer) {
  if (answer.ticket + 1 == map_ticket && answer.status != Status::kOk) {
    say(settings.map.text, answer.status == Status::kNotFound
                               ? "no such map yet; starting without one"
                               : "not a map of this version, or damaged; starting without one");
  }
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

void on_pps(void*, const bsp::Pps& pps) {
  stream_output.pps(pps);
  gnss.pulse(pps);
}

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
  gnss.for_each_counter([](const char* name, uint32_t value) { named("gnss", name, value); });
  named("output", "lines", poses.written());
  named("output", "datagrams", poses.sent());
  named("output", "dropped", poses.dropped());
  named("disk", "flushes", recordings.flushes());
  machine_load.for_each_counter(
      [](const char* name, uint64_t value) { named("system", name, value); });
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

void start_gnss() {
  if (!settings.gnss.is_wanted()) return;
  GnssSinks sinks;
  sinks.deliver = [](void*, const Arrival& arrival) { return app.deliver(arrival); };
  sinks.now = bsp::now;
  sinks.news.tell = on_news;
  const char* why = gnss.open(settings.gnss, sinks);
  if (why == nullptr) why = gnss.start_thread();
  if (why != nullptr) say("gnss", why);
}

void end_links() {
  serial.close();
  robot.close();
  gnss.close();
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
  sinks.fused = [](void*, const FusedPose& pose) { stream_output.fused(pose); };
  sinks.imu = [](void*, const ImuSample& sample) { stream_output.imu(sample); };
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
  load_map();
  start_links();
  start_gnss();
  machine_load.open();
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
  say("version", kVersion);
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
  machine_load.close();
  stream_output.close();
  watchdog.close();
  unwire_sensors();
  return started ? kExitDone : kExitFailed;
}

// A pin stays as it was when the program that drove it is killed.
int put_health_low(const char* config) {
  if (!read_config(config, settings)) return kExitBadInput;
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
  if (argc > 1 && std::strcmp(argv[1], "--version") == 0) {
    (void)!write(STDOUT_FILENO, kVersion, std::strlen(kVersion));
    (void)!write(STDOUT_FILENO, "\n", 1);
    return kExitDone;
  }
  if (argc == 3 && std::strcmp(argv[2], "--health-low") == 0) return put_health_low(argv[1]);
  const bool has_isps = kBoard.media != nullptr;
  if (!read_command_line(argc, argv, has_isps, settings)) return kExitBadInput;
  if (!read_device_calibration(settings, calibration)) return kExitBadInput;
  obey_signals();
  take_the_machine();
  return run();
}

}  // namespace
}  // namespace pirvs::board

int main(int argc, char** argv) { return pirvs::board::main_of(argc, argv); }
