// `pirvs view [SOURCE]`: a page that shows a device, a recording as it runs, or a finished run.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "board/host/board.h"
#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"
#include "tools/cli/command.h"
#include "tools/cli/stop.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording_options.h"
#include "tools/run/run_viewed.h"
#include "tools/view/device_view.h"
#include "tools/view/page.h"
#include "tools/view/run_view.h"
#include "tools/view/view.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUsbLink = "192.168.7.1";
constexpr const char* kUsbSerial = "/dev/ttyACM0";
constexpr const char* kUdp = "udp:";

struct Options {
  std::string source, serial;
  ViewOptions view;
  ViewedRun run;
  bool loop = false, once = false;
  std::string save;
};

void wait_for_end() {
  constexpr TimeNs kLook_ns = 100'000'000;
  while (stop_wanted == 0) bsp::sleep_until(bsp::now() + kLook_ns);
}

// "udp:HOST:PORT", or a host that is no file here.
bool is_device(const std::string& source) {
  return source.empty() || source.rfind(kUdp, 0) == 0 || !fs::exists(source);
}

// A recorded stream begins so (tools/listen/listener.cc).
bool is_stream(const std::string& source) {
  if (!fs::is_regular_file(source)) return false;
  char magic[8] = "";
  std::FILE* const file = std::fopen(source.c_str(), "rb");
  if (file == nullptr) return false;
  const size_t read = std::fread(magic, 1, sizeof magic, file);
  std::fclose(file);
  return std::string(magic, read) == "PVSTREA1";
}

DeviceViewOptions device_of(const Options& options) {
  DeviceViewOptions out = {options.source.empty() ? kUsbLink : options.source, options.serial};
  if (out.from.rfind(kUdp, 0) == 0) out.from.erase(0, std::string(kUdp).size());
  if (options.source.empty() && out.serial.empty() && fs::exists(kUsbSerial)) {
    out.serial = kUsbSerial;
  }
  return out;
}

int view_recording(View& view, const Options& options) {
  int status = 0;
  do {
    status = run_viewed(view, options.source, options.run);
    if (status >= kExitSignal) return kExitDone;
  } while (options.loop && status == kExitDone);
  stop_by_signals();
  if (options.once) return status;
  wait_for_end();
  return kExitDone;
}

int save(const Options& options) {
  if (!is_run_folder(options.source)) {
    throw InputError("not a finished run", options.source, "give a folder of `pirvs run --out`");
  }
  ViewScene scene;
  if (!options.view.earlier_map.empty()) scene.earlier_map(read_points(options.view.earlier_map));
  show_run(scene, options.source);
  save_page(scene.all(), options.save);
  return kExitDone;
}

int view(const Options& options) {
  if (!options.save.empty()) return save(options);
  stop_by_signals();
  View view(options.view);
  if (is_device(options.source) || is_stream(options.source)) {
    view_device(view, device_of(options), stop_wanted);
    if (!options.once) wait_for_end();
    return kExitDone;
  }
  if (!is_run_folder(options.source)) return view_recording(view, options);
  show_run(view.scene(), options.source);
  wait_for_end();
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SOURCE", o->source,
                 "a device, udp:HOST:PORT (default: the USB link, 192.168.7.1:14560); a recording, "
                 "which runs in real time; a folder of `run --out`; a file of `listen --record`");
  add_view_options(app, o->view);
  app.add_option("--serial", o->serial,
                 "tty of a device that takes commands (default with the USB link: /dev/ttyACM0)");
  app.add_option("--save", o->save,
                 "FILE, a finished run: write it as a page of its own, and serve nothing");
  app.add_flag("--loop", o->loop, "a recording: again and again");
  app.add_flag("--once", o->once, "end with the recording, and do not wait for Ctrl-C");
  app.add_option("--cores", o->run.cores, "a recording: threads")
      ->capture_default_str()
      ->check(CLI::Range(1, board::kCores));
  app.add_option("--files", o->run.files, "a recording: folder of `map save` and `map load`")
      ->check(CLI::ExistingDirectory);
  app.add_option("--load-map", o->run.load_map,
                 "FILE, a recording: a map that it starts in (docs/maps.md)")
      ->check(CLI::ExistingFile);
  app.add_option("--set", o->run.set, "a recording: name=value, a parameter")
      ->allow_extra_args(false);
  add_recording_options(app, o->run.recording);
  app.footer("The page: docs/view.md. Ctrl-C ends.");
  return [o] { return view(*o); };
}

}  // namespace

const Command kViewCommand = {"view", "Show a device, a recording as it runs, or a run as a page",
                              declare};

}  // namespace pirvs::tools
