// pirvs-receive: takes an update from a PC and has RAUC install it. systemd starts one for each
// connection to the USB link, with the connection as standard input and output (lines.h).
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "board/card/receive/lines.h"
#include "board/card/slot_state.h"
#include "core/base/text.h"

namespace pirvs::card {
namespace {

constexpr const char* kFolder = "/run/pirvs-update";
constexpr const char* kBundle = "/run/pirvs-update/bundle.raucb";
constexpr const char* kLock = "/run/pirvs-update/lock";
constexpr int kSilence_s_max = 20;
constexpr size_t kLineMax = 512;

uint8_t block[1 << 16];

bool say(const char* line, std::string_view rest = {}) {
  Text<kLineMax> out;
  out.put(line);
  for (const char c : rest) out.put(c);
  out.put('\n');
  return write(STDOUT_FILENO, out.c_str(), out.size()) == static_cast<ssize_t>(out.size());
}

int refuse(const char* why, std::string_view more = {}) {
  Text<kLineMax> line;
  line.put("refused ").put(why);
  say(line.c_str(), more);
  return 1;
}

std::string_view read_small(const char* path, char* out, size_t max) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  const ssize_t size = fd < 0 ? 0 : read(fd, out, max);
  if (fd >= 0) close(fd);
  return {out, size < 0 ? 0 : static_cast<size_t>(size)};
}

// ---- what runs ---------------------------------------------------------------------------------

char running_slot() {
  static char text[4096];
  const std::string_view slot =
      find_word(read_small("/proc/cmdline", text, sizeof text), "rauc.slot");
  return slot.size() == 1 ? slot[0] : '?';
}

bool read_card(SlotState& out) {
  static Sector sectors[2];
  const int fd = open("/dev/pirvs-card", O_RDONLY | O_CLOEXEC);
  bool whole = fd >= 0;
  for (int i = 0; i < 2 && whole; ++i) {
    const auto at = static_cast<off_t>(kStateSectors[i] * kSectorBytes);
    whole = pread(fd, sectors[i], kSectorBytes, at) == static_cast<ssize_t>(kSectorBytes);
  }
  if (fd >= 0) close(fd);
  if (whole) (void)read_state(sectors[0], sectors[1], out);
  return whole;
}

int answer_version() {
  static char text[4096];
  const std::string_view version =
      find_value(read_small("/etc/os-release", text, sizeof text), "VERSION_ID");
  SlotState state;
  if (!read_card(state)) return refuse("the card's state cannot be read");
  const char slot = running_slot();
  Text<kLineMax> line;
  line.put("version ");
  for (const char c : version) line.put(c);
  line.put(" slot ").put(slot);
  if (state.trial == slot) {
    line.put(" trial ").number(state.left);
  } else {
    line.put(" good");
  }
  static char boot[64];
  std::string_view id = read_small("/proc/sys/kernel/random/boot_id", boot, sizeof boot);
  line.put(" boot ");
  for (const char c : id.substr(0, id.find('\n'))) line.put(c);
  return say(line.c_str()) ? 0 : 1;
}

// ---- an update ---------------------------------------------------------------------------------

bool write_all(int fd, const uint8_t* from, size_t size) {
  while (size > 0) {
    const ssize_t done = write(fd, from, size);
    if (done <= 0) return false;
    from += done;
    size -= static_cast<size_t>(done);
  }
  return true;
}

// In memory, and all others that keep something there find room as well.
bool has_room(uint64_t bytes) {
  constexpr uint64_t kForOthers = 16 << 20;
  struct statvfs about {};
  if (statvfs(kFolder, &about) != 0) return false;
  return bytes + kForOthers <= uint64_t{about.f_bavail} * about.f_frsize;
}

// nullptr, or why not.
const char* receive(int fd, uint64_t bytes) {
  while (bytes > 0) {
    const size_t wanted = bytes < sizeof block ? static_cast<size_t>(bytes) : sizeof block;
    const ssize_t got = read(STDIN_FILENO, block, wanted);
    if (got == 0) return "the connection ended in the middle of the bundle";
    if (got < 0) return errno == EAGAIN ? "nothing came for 20 s" : std::strerror(errno);
    if (!write_all(fd, block, static_cast<size_t>(got))) return "no memory for the bundle";
    bytes -= static_cast<uint64_t>(got);
  }
  return nullptr;
}

// What RAUC says goes on as lines, and into the journal; its error is kept.
struct Report {
  char error[kLineMax] = "";

  void line(std::string_view text) {
    (void)!write(STDERR_FILENO, text.data(), text.size());
    (void)!write(STDERR_FILENO, "\n", 1);
    const RaucLine told = parse_rauc(text);
    if (told.kind == RaucLine::Kind::kError) {
      const size_t size = told.text.size() < kLineMax - 1 ? told.text.size() : kLineMax - 1;
      std::memcpy(error, told.text.data(), size);
      error[size] = 0;
    }
    if (told.kind != RaucLine::Kind::kProgress) return;
    Text<32> start;
    start.put("progress ").number(told.percent).put(' ');
    say(start.c_str(), told.text);
  }
};

// Its exit status.
int install(Report& report) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    execl("/usr/bin/rauc", "rauc", "install", kBundle, nullptr);
    _exit(127);
  }
  close(ends[1]);
  char text[kLineMax];
  size_t size = 0;
  ssize_t got = 0;
  while (child > 0 && (got = read(ends[0], text + size, 1)) == 1) {
    if (text[size] != '\n' && ++size < sizeof text) continue;
    report.line({text, size});
    size = 0;
  }
  close(ends[0]);
  int status = -1;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

int restart() {
  execl("/bin/systemctl", "systemctl", "reboot", nullptr);
  return 1;
}

int take_update(uint64_t bytes) {
  (void)mkdir(kFolder, 0700);
  const int lock = open(kLock, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock < 0 || flock(lock, LOCK_EX | LOCK_NB) != 0) return refuse("another update is running");
  SlotState state;
  if (!read_card(state)) return refuse("the card's state cannot be read");
  if (state.good != running_slot()) {
    return refuse("the version that runs is on trial still: try again in a minute");
  }
  if (!has_room(bytes)) return refuse("no memory for the bundle");
  const int fd = open(kBundle, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return refuse("no memory for the bundle");
  if (!say("ready")) return 1;
  const char* const why = receive(fd, bytes);
  close(fd);
  Report report;
  const int status = why == nullptr ? install(report) : 0;
  unlink(kBundle);
  if (why != nullptr) return refuse(why);
  if (status != 0) {
    return refuse(report.error[0] != 0 ? report.error : "RAUC could not install it");
  }
  if (!say("installed")) return restart();
  shutdown(STDOUT_FILENO, SHUT_WR);
  return restart();
}

int serve() {
  const timeval silence = {kSilence_s_max, 0};
  setsockopt(STDIN_FILENO, SOL_SOCKET, SO_RCVTIMEO, &silence, sizeof silence);
  setsockopt(STDIN_FILENO, SOL_SOCKET, SO_SNDTIMEO, &silence, sizeof silence);
  signal(SIGPIPE, SIG_IGN);
  char line[64];
  size_t size = 0;
  while (size < sizeof line && read(STDIN_FILENO, line + size, 1) == 1 && line[size] != '\n') {
    ++size;
  }
  const Request request = parse_request({line, size});
  switch (request.kind) {
    case Request::Kind::kVersion:
      return answer_version();
    case Request::Kind::kUpdate:
      return take_update(request.bytes);
    case Request::Kind::kNone:
      break;
  }
  return refuse("not a request of pirvs update");
}

}  // namespace
}  // namespace pirvs::card

int main() { return pirvs::card::serve(); }
