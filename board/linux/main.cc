// pirvsd: the whole stack on live sensors, as a program of Linux. See kHelp, and docs/device.md.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>

#include "board/linux/board.h"
#include "board/linux/image_share.h"
#include "board/linux/pose_output.h"
#include "board/linux/serial_link.h"
#include "board/linux/settings.h"
#include "board/linux/wiring.h"
#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/api/events.h"
#include "bsp/linux/storage.h"
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
    "  --imu          iio:0, or by the name of its driver, iio:mpu6500\n"
    "  --calibration  written by `pirvs calibration`\n"
    "  --set          any key of the file, output.text=frames\n"
    "Poses come on standard output, one a line: t x y z qx qy qz qw health confidence.\n"
    "News of sensors and health come on standard error. SIGTERM and SIGINT end it in order.\n"
    "Exit status: 0 ended by a signal, 1 a core could not be started, 2 bad input.\n";

App app;
Settings settings;
PoseOutput poses;
SerialLink serial;
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

void on_answer(void*, const Answer& answer) { serial.answer(answer); }

void on_health(void*, TimeNs t, HealthState state, const char* what) {
  constexpr int kMillis = 3;
  Text<192> line;
  line.put("pirvsd: ").fixed(to_seconds(t), kMillis).put(' ').put(name(state)).put(", ").put(what);
  say(line);
}

// A task that is late again and again: this machine is too slow for these sensors.
void on_late(void*, TimeNs t, const LateTask& task) {
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
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    say(path, std::strerror(errno));
    return false;
  }
  size_t size = 0;
  ssize_t got = 0;
  while (size < max && (got = read(fd, out + size, max - size)) > 0) {
    size += static_cast<size_t>(got);
  }
  close(fd);
  if (got < 0) say(path, std::strerror(errno));
  if (size == max) say(path, "the file is too large");
  text = {out, size};
  return got == 0 && size < max;
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
    camera.width = calibration.camera[c].width;
    camera.height = calibration.camera[c].height;
  }
  out.imu = settings.iio;
  out.imu.device = settings.imu.text;
  out.news.tell = on_news;
  out.core = kBoard.plan.door;
  if (images.is_open()) out.frame = [](const StereoFrame& frame) { images.frame(frame); };
  return out;
}

bool start_record() {
  if (settings.record.text[0] == 0) return true;
  (void)mkdir(settings.record.text, 0755);  // app.record() tells when this was in vain
  bsp::set_storage_directory(settings.record.text);
  const Status status = app.record();
  if (status != Status::kOk) say(settings.record.text, "cannot record there");
  return status == Status::kOk;
}

// ---- the end -----------------------------------------------------------------------------------

void say_counter(const char* device, const char* name, uint64_t value) {
  if (value == 0) return;
  Text<160> line;
  line.put("counter ").put(device).put(device[0] != 0 ? "." : "").put(name).put(' ');
  line.unsigned_number(value);
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
  NamedValue values[kCountersMax];
  const int count = app.counters(values, kCountersMax);
  for (int i = 0; i < count; ++i) say_counter("", values[i].name, values[i].value);
  for_each_sensor_counter([](const char* device, const char* name, uint32_t value) {
    say_counter(device, name, value);
  });
  say_counter("output", "lines", poses.written());
  say_counter("output", "datagrams", poses.sent());
  say_counter("output", "dropped", poses.dropped());
  say_latency("imu_to_pose", app.latency().imu_to_pose.summary());
  say_latency("exposure_to_fused", app.latency().exposure_to_fused.summary());
}

// ` name=value` of what is not zero.
void put_counters(void*, TextWriter& out) {
  NamedValue values[kCountersMax];
  const int count = app.counters(values, kCountersMax);
  for (int i = 0; i < count; ++i) {
    if (values[i].value == 0) continue;
    out.put(' ').put(values[i].name).put('=').unsigned_number(values[i].value);
  }
}

void start_links() {
  const auto command = [](void*, const Command& command) { return app.command(command); };
  serial.configure(settings.serial.text, {nullptr, command, put_counters});
  if (serial.wanted()) poses.also([](const TextWriter& line) { serial.pose(line); });
  if (settings.images.text[0] == 0) return;
  const Camera& camera = calibration.camera[0];
  const Status status =
      images.open(settings.images.text, calibration.cameras, camera.width, camera.height);
  if (status != Status::kOk) say(settings.images.text, "images cannot be given out there");
}

void end_links() {
  for_each_counter(serial.counters(), kSerialLinkRows,
                   [](const char* name, uint32_t value) { say_counter("serial", name, value); });
  for_each_counter(images.counters(), kImageShareRows,
                   [](const char* name, uint32_t value) { say_counter("images", name, value); });
  serial.close();
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
  app.configure(calibration, settings.params, sinks);
  app.set_clock(bsp::now);
  if (!start_record()) return kExitBadInput;
  if (poses.configure(settings, app.poses()) != Status::kOk) {
    say("output.poses", "no socket for the datagrams");
    return kExitBadInput;
  }
  start_links();
  wire_sensors(sensors());
  const bool started = app.start(kBoard.plan, Drive::kTimed) == Status::kOk;
  if (!started) say("cores", "a thread could not be started");
  if (const char* const why = bsp::core_refusals()) say(kBoard.name, why);
  bool asked_to_stop = false;
  while (started && app.poll() != Status::kStale) {
    poses.send();
    serial.poll(bsp::now());
    stop_when_wanted(asked_to_stop);
  }
  (void)app.finish();  // a run that never found a start is no failure of the program
  poses.send();
  say_counters();
  end_links();
  poses.close();
  unwire_sensors();
  return started ? kExitDone : kExitFailed;
}

int main_of(int argc, char** argv) {
  if (argc > 1 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0)) {
    (void)!write(STDOUT_FILENO, kHelp, std::strlen(kHelp));
    return kExitDone;
  }
  if (!read_command_line(argc, argv) || !read_device_calibration()) return kExitBadInput;
  obey_signals();
  take_the_machine();
  return run();
}

}  // namespace
}  // namespace pirvs::board

int main(int argc, char** argv) { return pirvs::board::main_of(argc, argv); }
