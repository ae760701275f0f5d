// pirvs-usb: the device on USB, as kHelp says.
#include <dirent.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "board/usb/gadget.h"
#include "board/usb/uvc_feeder.h"
#include "board/usb/uvc_holder.h"
#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/linux/text_file.h"
#include "core/base/text.h"

namespace pirvs::board {
namespace {

constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitBadInput = 2;

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr int kLook_ms = 200;  // for a UDC, or a node that udev has not made yet

constexpr const char* kConfigfs = "/sys/kernel/config";

constexpr const char* kHelp =
    "pirvs-usb: makes this device a USB gadget: network (NCM), serial line (ACM), camera (UVC).\n"
    "usage: pirvs-usb [CONFIG] [--set KEY=VALUE]...\n"
    "  CONFIG   the device's file: its keys `usb.` and output.images, others are pirvsd's\n"
    "It holds the camera's node and does nothing else, or the gadget would leave the bus; images\n"
    "are fed by a process of their own, pirvs-video, which is started again when it ends.\n"
    "SIGTERM and SIGINT take the gadget away.\n"
    "Exit status: 0 ended by a signal, 1 the kernel refused, 2 bad input.\n";

GadgetSetup setup;
UvcHolder holder;
UvcFeeder feeder;
char config_text[16'384];

void say(const char* where, const char* what) {
  Text<384> line;
  line.put("pirvs-usb: ").put(where).put(": ").put(what).put('\n');
  bsp::console_write(line.c_str());
}

// ---- input -------------------------------------------------------------------------------------

bool say_fault(const char* path, const ConfigFault& fault) {
  Text<384> line;
  line.put("pirvs-usb: ");
  put_fault(line, path, fault);
  bsp::console_write(line.put('\n').c_str());
  return false;
}

bool read_config(const char* path) {
  std::string_view text;
  if (const char* const why = bsp::read_text_file(path, config_text, sizeof config_text, text)) {
    say(path, why);
    return false;
  }
  const ConfigFault fault = read_usb_settings(text, setup.usb);
  return !fault || say_fault(path, fault);
}

bool take_assignment(std::string_view text) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return say_fault("command line", {0, "--set wants KEY=VALUE", text});
  }
  const std::string_view key = text.substr(0, equals);
  const char* const why = set_usb_setting(setup.usb, key, text.substr(equals + 1));
  return why == nullptr || say_fault("command line", {0, why, key});
}

bool read_command_line(int argc, char** argv) {
  int at = 1;
  if (at < argc && argv[at][0] != '-' && !read_config(argv[at++])) return false;
  for (; at < argc; at += 2) {
    if (std::strcmp(argv[at], "--set") != 0 || at + 1 == argc) {
      return say_fault("command line", {0, "--set KEY=VALUE, see --help", argv[at]});
    }
    if (!take_assignment(argv[at + 1])) return false;
  }
  return true;
}

// The board's own number is the same for every system on its card; a machine's id must not be seen
// from outside, says machine-id(5).
void find_serial() {
  char text[128];
  std::string_view read;
  if (setup.usb.serial[0] != 0) {
    std::strcpy(setup.serial, setup.usb.serial);
  } else if (bsp::read_text_file("/proc/device-tree/serial-number", text, sizeof text, read) ==
                 nullptr &&
             std::strlen(text) > 0 && std::strlen(text) < sizeof setup.serial) {
    std::strcpy(setup.serial, text);
  } else {
    (void)bsp::read_text_file("/etc/machine-id", text, sizeof text, read);
    put_digest(read.empty() ? "" : text, setup.serial);
  }
}

// ---- what the kernel has -----------------------------------------------------------------------

// The first one; a board has one that is wired to its connector.
bool find_udc(char* out, size_t max) {
  DIR* const folder = opendir("/sys/class/udc");
  if (folder == nullptr) return false;
  bool found = false;
  while (const dirent* const entry = found ? nullptr : readdir(folder)) {
    found = entry->d_name[0] != '.' && std::strlen(entry->d_name) < max;
    if (found) std::strcpy(out, entry->d_name);
  }
  closedir(folder);
  return found;
}

// By the name that its function has here: hosts of other gadgets may be on this machine, too.
bool find_node(char* out, size_t max) {
  constexpr int kNodes = 64;
  for (int i = 0; i < kNodes; ++i) {
    Text<96> path;
    path.put("/sys/class/video4linux/video").number(i).put("/function_name");
    char name[32];
    std::string_view text;
    if (bsp::read_text_file(path.c_str(), name, sizeof name, text) != nullptr) continue;
    if (text.substr(0, text.find('\n')) != "uvc.0") continue;
    TextWriter(out, max).put("/dev/video").number(i);
    return access(out, F_OK) == 0;
  }
  return false;
}

uint8_t interface_of(const char* part) {
  Text<160> path;
  path.put(kConfigfs).put("/usb_gadget/pirvs/functions/uvc.0/").put(part);
  path.put("/bInterfaceNumber");
  char number[16];
  std::string_view text;
  int64_t value = 0;
  const bool good = bsp::read_text_file(path.c_str(), number, sizeof number, text) == nullptr &&
                    read_whole(text.substr(0, text.find('\n')), 0, 255, value);
  if (!good) say(path.c_str(), "no number of an interface");
  return static_cast<uint8_t>(value);
}

// ---- life --------------------------------------------------------------------------------------

class Signals {
 public:
  void take() {
    sigset_t set;
    sigemptyset(&set);
    for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGCHLD}) sigaddset(&set, number);
    sigprocmask(SIG_BLOCK, &set, nullptr);
    fd_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    signal(SIGPIPE, SIG_IGN);  // of a feeder that is gone
  }
  // True: one that ends the program has come.
  bool end_wanted() {
    signalfd_siginfo info;
    while (read(fd_, &info, sizeof info) == sizeof info) ended_ |= info.ssi_signo != SIGCHLD;
    return ended_;
  }
  int fd() const { return fd_; }

 private:
  int fd_ = -1;
  bool ended_ = false;
};
Signals signals;

// The process that feeds the camera.
class FeederProcess {
 public:
  void keep_up(TimeNs now) {
    if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) {
      say("pirvs-video", "ended, starting it again");
      gone();
      next_t_ = now + kSecond_ns;
    }
    if (pid_ <= 0 && now >= next_t_) start();
  }
  void tell(bool streaming) {
    if (control_ < 0 || (told_ && streaming == streaming_)) return;
    const uint8_t said = streaming;
    told_ = write(control_, &said, 1) == 1;
    streaming_ = streaming;
  }
  void end() {
    if (pid_ > 0 && kill(pid_, SIGKILL) == 0) waitpid(pid_, nullptr, 0);
    gone();
  }
  bool runs() const { return pid_ > 0; }

 private:
  void gone() {
    if (control_ >= 0) close(control_);
    control_ = pid_ = -1;
    told_ = false;
  }
  void start();

  pid_t pid_ = -1;
  int control_ = -1;
  bool told_ = false, streaming_ = false;
  TimeNs next_t_ = 0;
};
FeederProcess feeder_process;

[[noreturn]] void run_feeder(int control, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // or the node would stay held, and the gadget on the bus
  if (getppid() != parent) _exit(0);
  prctl(PR_SET_NAME, "pirvs-video");
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  FeederSetup fed;
  fed.node = holder.fd();
  fed.control = control;
  fed.images = setup.usb.images;
  fed.camera = setup.usb.video == UsbVideo::kRight ? 1 : 0;
  fed.width = setup.usb.width;
  fed.height = setup.usb.height;
  fed.tell = [](const char* what) { say("pirvs-video", what); };
  if (feeder.open(fed)) {
    feeder.run();
  } else {
    say("pirvs-video", "the camera's buffers cannot be had");
  }
  _exit(0);
}

void FeederProcess::start() {
  int ends[2];
  if (pipe(ends) != 0) return;
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    close(ends[1]);
    run_feeder(ends[0], parent);
  }
  close(ends[0]);
  control_ = ends[1];
  if (pid_ < 0) gone();
}

// False: a signal ended it.
template <class Found>
bool wait_for(const char* what, Found&& found) {
  bool told = false;
  while (!found()) {
    if (!told) say(what, "not there, waiting for it");
    told = true;
    pollfd signal = {signals.fd(), POLLIN, 0};
    (void)poll(&signal, 1, kLook_ms);
    if (signals.end_wanted()) return false;
  }
  return true;
}

// Returns when a signal ends it, or when the node is gone: false.
bool hold() {
  for (;;) {
    pollfd polled[2] = {{signals.fd(), POLLIN, 0}, {holder.fd(), POLLPRI, 0}};
    const int timeout_ms = holder.fd() < 0 || feeder_process.runs() ? -1 : kLook_ms;
    (void)poll(polled, 2, timeout_ms);
    if (signals.end_wanted()) return true;
    if (holder.fd() < 0) continue;
    if (polled[1].revents != 0 && !holder.on_events()) return false;
    feeder_process.keep_up(bsp::now());
    feeder_process.tell(holder.streaming());
  }
}

const char* hold_camera() {
  static char node[32];
  if (!wait_for("the camera's node", [] { return find_node(node, sizeof node); })) return nullptr;
  UvcFormat format;
  format.width = setup.usb.width;
  format.height = setup.usb.height;
  format.interval = static_cast<uint32_t>(1e7 / setup.usb.rate_hz);
  format.control_interface = interface_of("control");
  format.streaming_interface = interface_of("streaming");
  return holder.open(node, format);
}

int run() {
  static char udc[64];
  const Gadget gadget(kConfigfs);
  gadget.remove();
  if (!wait_for("USB device controller", [] { return find_udc(udc, sizeof udc); })) {
    return kExitDone;
  }
  setup.udc = udc;
  if (const char* const row = gadget.make(setup)) {
    const char* const why = std::strerror(errno);
    say(row[0] != 0 ? row : "usb_gadget/pirvs (is libcomposite loaded?)", why);
    return kExitFailed;
  }
  say(udc, setup.serial);
  const char* why = setup.usb.video == UsbVideo::kNone ? nullptr : hold_camera();
  if (why != nullptr) say("camera", why);
  const bool ended = why == nullptr && hold();
  feeder_process.end();
  holder.close();
  gadget.remove();
  return ended ? kExitDone : kExitFailed;
}

int main_of(int argc, char** argv) {
  if (argc > 1 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0)) {
    (void)!write(STDOUT_FILENO, kHelp, std::strlen(kHelp));
    return kExitDone;
  }
  if (!read_command_line(argc, argv)) return kExitBadInput;
  find_serial();
  signals.take();
  return run();
}

}  // namespace
}  // namespace pirvs::board

int main(int argc, char** argv) { return pirvs::board::main_of(argc, argv); }
