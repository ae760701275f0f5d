// The PC at the other end of the device's USB, in tests/device/usb_test.cc: takes poses from the
// network and from the serial line, gives commands, looks at the camera, and kills pirvs-video.
// usage: usb_peer PACK SECONDS   in a network namespace of its own, into which the test's init puts
//        the interface once there is /run/peer. SECONDS, at least 20, after the first pose it pulls
//        the cable and puts it back, and ends with `stop` to pirvsd.
//        usb_peer cost           how busy the machine is without poses, and by how much more with
//                                200 a second by either way
// Out     On standard output: `name value` of what was counted; "answer LINE" of each answer.
#include <arpa/inet.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/api/clock.h"
#include "bsp/replay/pack.h"
#include "modules/output/pose_text.h"

namespace pirvs {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;
constexpr uint16_t kPort = 14550;
constexpr const char* kHost = "192.168.7.2";
constexpr const char* kTty = "/dev/ttyACM0";

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

void tell(const char* name, double value) { std::printf("%s %.10g\n", name, value); }

// ---- poses -------------------------------------------------------------------------------------

// Pose lines as they came: a step of stamps of more than one period is poses that are missing.
struct PoseCount {
  unsigned lines = 0, missing = 0, torn = 0;
  double first_t = 0, t = 0;

  void take(const char* line) {
    constexpr double kPeriod_s = 0.005;
    double now = 0, number = 0;
    char health[32];
    int used = 0;
    const bool whole =
        std::sscanf(line, "%lf %lf %lf %lf %lf %lf %lf %lf %31s %lf%n", &now, &number, &number,
                    &number, &number, &number, &number, &number, health, &number, &used) == 10 &&
        (line[used] == 0 || line[used] == '\n');
    if (!whole || now <= t) {
      ++torn;
      return;
    }
    if (lines == 0) first_t = now;
    if (lines > 0) missing += static_cast<unsigned>(std::lround((now - t) / kPeriod_s)) - 1;
    t = now;
    ++lines;
  }
  void tell_all(const char* name) const {
    std::printf("%s.lines %u\n%s.missing %u\n%s.torn %u\n%s.seconds %.3f\n", name, lines, name,
                missing, name, torn, name, t - first_t);
  }
};

// ---- network -----------------------------------------------------------------------------------

bool find_interface(ifreq& out) {
  for (int index = 1; index < 16; ++index) {
    char name[IF_NAMESIZE];
    if (if_indextoname(static_cast<unsigned>(index), name) == nullptr) continue;
    if (std::strcmp(name, "lo") == 0) continue;
    std::strcpy(out.ifr_name, name);
    return true;
  }
  return false;
}

// Waits until the test's init has put the interface here.
int open_network() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  ifreq request{};
  for (int i = 0; i < 100 && !find_interface(request); ++i) usleep(50'000);
  auto& address = reinterpret_cast<sockaddr_in&>(request.ifr_addr);
  address.sin_family = AF_INET;
  inet_aton(kHost, &address.sin_addr);
  if (ioctl(fd, SIOCSIFADDR, &request) != 0) fail("the interface's address");
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  if (ioctl(fd, SIOCSIFFLAGS, &request) != 0) fail("the interface up");
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(kPort);
  const int room = 1 << 20;
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) fail("bind");
  // Where measure_costs() sends: without it each datagram would have an answer.
  own.sin_port = htons(kPort + 1);
  const int other = socket(AF_INET, SOCK_DGRAM, 0);
  if (bind(other, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) fail("bind");
  return fd;
}

// Bytes that have come by the interface, Ethernet's included.
double received_bytes() {
  FILE* const in = std::fopen("/proc/self/net/dev", "r");
  char line[256], name[32];
  double bytes = 0;
  while (in != nullptr && std::fgets(line, sizeof line, in) != nullptr) {
    double value = 0;
    if (std::sscanf(line, " %31[^:]: %lf", name, &value) == 2 && std::strcmp(name, "lo") != 0) {
      bytes = value;
    }
  }
  if (in != nullptr) std::fclose(in);
  return bytes;
}

void take_datagrams(int fd, PoseCount& count) {
  char line[512];
  ssize_t got = 0;
  while ((got = recv(fd, line, sizeof line - 1, 0)) > 0) {
    line[got] = 0;
    count.take(line);
  }
}

// ---- serial line -------------------------------------------------------------------------------

int open_tty(const char* path) {
  const int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK);
  termios line{};
  if (fd < 0 || tcgetattr(fd, &line) != 0) fail(path);
  cfmakeraw(&line);
  tcsetattr(fd, TCSANOW, &line);
  return fd;
}

struct SerialPeer {
  int fd = -1;
  char line[8192];
  size_t size = 0;
  PoseCount poses;
  unsigned answers = 0;

  // A line that has just come may take nothing yet.
  void say(const char* text) const {
    size_t left = std::strlen(text);
    for (int tries = 0; left > 0 && tries < 40; ++tries) {
      const ssize_t wrote = write(fd, text, left);
      if (wrote < 0 && errno != EAGAIN) break;
      if (wrote > 0) {
        text += wrote;
        left -= static_cast<size_t>(wrote);
        continue;
      }
      pollfd room{fd, POLLOUT, 0};
      poll(&room, 1, 50);
    }
    if (left > 0) std::perror("serial");
  }
  void read_all() {
    char bytes[4096];
    ssize_t got = 0;
    while ((got = read(fd, bytes, sizeof bytes)) > 0) {
      for (ssize_t i = 0; i < got; ++i) {
        if (bytes[i] != '\n' && size + 1 < sizeof line) {
          line[size++] = bytes[i];
          continue;
        }
        line[size] = 0;
        size = 0;
        take_line();
      }
    }
  }
  void take_line() {
    if (line[0] == '#') return;  // of the measurement of costs
    const bool answer = std::strncmp(line, "ok", 2) == 0 || std::strncmp(line, "error", 5) == 0;
    if (!answer) return poses.take(line);
    ++answers;
    std::printf("answer %s\n", line);
  }
};

// One after the other, with what comes between whole lines elsewhere.
constexpr const char* kTyped[] = {
    "help\n",
    "pose\r\n",
    "parameter frontend.tracks_target 100\r",
    "parameter nobody.knows 1\n",
    "\x01\xff\x7f garbage\n",
    "too long 0123456789012345678901234567890123456789012345678901234567890123456789"
    "0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890\n",
    "map load ../etc/passwd\n",
    "record start\n",
    "record stop\n",
    "counters\n",
    "record start\n",
    "record stop\n",
};

// ---- camera ------------------------------------------------------------------------------------

pid_t find_process(const char* name) {
  DIR* const folder = opendir("/proc");
  pid_t found = 0;
  while (const dirent* const entry = folder != nullptr ? readdir(folder) : nullptr) {
    const int pid = std::atoi(entry->d_name);
    char path[64], text[64] = "";
    std::snprintf(path, sizeof path, "/proc/%d/comm", pid);
    FILE* const in = pid > 0 ? std::fopen(path, "r") : nullptr;
    if (in == nullptr) continue;
    if (std::fscanf(in, "%63s", text) == 1 && std::strcmp(text, name) == 0) found = pid;
    std::fclose(in);
  }
  if (folder != nullptr) closedir(folder);
  return found;
}

// A V4L2 camera of uvcvideo, and whether what it shows are the pack's images, in order.
class CameraPeer {
 public:
  explicit CameraPeer(const bsp::Pack& pack) : pack_(pack) {}

  void open() {
    char path[32];
    for (int i = 0; i < 16 && fd_ < 0; ++i) {
      std::snprintf(path, sizeof path, "/dev/video%d", i);
      const int fd = ::open(path, O_RDWR | O_NONBLOCK);
      v4l2_capability about{};
      const bool ours = fd >= 0 && ioctl(fd, VIDIOC_QUERYCAP, &about) == 0 &&
                        std::strcmp(reinterpret_cast<const char*>(about.driver), "uvcvideo") == 0 &&
                        (about.device_caps & V4L2_CAP_VIDEO_CAPTURE) != 0;
      if (ours) fd_ = fd;
      if (!ours && fd >= 0) ::close(fd);
    }
    if (fd_ < 0) fail("no camera of uvcvideo");
  }
  void close() {
    ::close(fd_);
    fd_ = -1;
  }
  void start() {
    const Camera camera = pack_.camera(0);
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = static_cast<uint32_t>(camera.width);
    format.fmt.pix.height = static_cast<uint32_t>(camera.height);
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
    if (ioctl(fd_, VIDIOC_S_FMT, &format) != 0) fail("VIDIOC_S_FMT");
    tell("video.width", format.fmt.pix.width);
    tell("video.height", format.fmt.pix.height);
    tell("video.grey", format.fmt.pix.pixelformat == V4L2_PIX_FMT_GREY);
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (ioctl(fd_, VIDIOC_REQBUFS, &request) != 0) fail("VIDIOC_REQBUFS");
    for (uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = buffer_of(i);
      if (ioctl(fd_, VIDIOC_QUERYBUF, &buffer) != 0) fail("VIDIOC_QUERYBUF");
      memory_[i] = static_cast<uint8_t*>(
          mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, fd_, buffer.m.offset));
      size_[i] = buffer.length;
      if (ioctl(fd_, VIDIOC_QBUF, &buffer) != 0) fail("VIDIOC_QBUF");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ioctl(fd_, VIDIOC_STREAMON, &type) != 0) fail("VIDIOC_STREAMON");
    streaming_ = true;
    goes_on_ = false;
  }
  // Once, somewhere behind the images that are on their way.
  void allow_gap() { gap_allowed_ = true; }
  void stop() {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ioctl(fd_, VIDIOC_STREAMOFF, &type) != 0) fail("VIDIOC_STREAMOFF");
    for (int i = 0; i < kBuffers; ++i) munmap(memory_[i], size_[i]);
    v4l2_requestbuffers request{};
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    ioctl(fd_, VIDIOC_REQBUFS, &request);
    streaming_ = false;
  }
  void read_all() {
    v4l2_buffer buffer = buffer_of(0);
    while (streaming_ && ioctl(fd_, VIDIOC_DQBUF, &buffer) == 0) {
      check(memory_[buffer.index], buffer.bytesused, buffer.flags);
      if (ioctl(fd_, VIDIOC_QBUF, &buffer) != 0) fail("VIDIOC_QBUF");
    }
  }
  int fd() const { return fd_; }
  bool streaming() const { return streaming_; }
  unsigned images() const { return same_ + other_; }
  void tell_all() const {
    tell("video.same", same_);
    tell("video.other", other_);
    tell("video.damaged", damaged_);
    tell("video.skipped", skipped_);
  }

 private:
  static constexpr int kBuffers = 4;

  static v4l2_buffer buffer_of(uint32_t index) {
    v4l2_buffer out{};
    out.index = index;
    out.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    out.memory = V4L2_MEMORY_MMAP;
    return out;
  }
  // The feeder plays the recording's end again and again.
  uint32_t after(uint32_t i) const {
    constexpr TimeNs kLoopFrom_ns = 2 * kSecond;  // as feeder.cc has it
    if (i + 1 < pack_.header().frame_count) return i + 1;
    uint32_t first = 0;
    while (pack_.frame(first).t < pack_.frame(0).t + kLoopFrom_ns) ++first;
    return first;
  }
  void check(const uint8_t* pixels, uint32_t size, uint32_t flags) {
    const Camera camera = pack_.camera(0);
    const auto bytes = static_cast<uint32_t>(camera.width * camera.height);
    if ((flags & V4L2_BUF_FLAG_ERROR) != 0 || size != bytes) {
      ++damaged_;
      return;
    }
    uint32_t i = next_;
    for (uint32_t step = 0; step < pack_.header().frame_count; ++step, i = after(i)) {
      if (std::memcmp(pixels, pack_.frame(i).image[0].data, bytes) != 0) continue;
      if (goes_on_ && step > 0 && !gap_allowed_) skipped_ += step;
      if (goes_on_ && step > 0) gap_allowed_ = false;
      goes_on_ = true;
      next_ = after(i);
      ++same_;
      return;
    }
    ++other_;
  }

  const bsp::Pack& pack_;
  int fd_ = -1;
  bool streaming_ = false;
  uint8_t* memory_[kBuffers] = {};
  size_t size_[kBuffers] = {};
  uint32_t next_ = 0;
  bool goes_on_ = false, gap_allowed_ = false;
  unsigned same_ = 0, other_ = 0, damaged_ = 0, skipped_ = 0;
};

// ---- the PC ------------------------------------------------------------------------------------

// What happens, so many seconds after the first pose.
constexpr double kLook_s = 3, kKill_s = 6, kLookAway_s = 12, kLookAgain_s = 14, kLookNoMore_s = 18;
constexpr double kType_s = 1.5;  // from command to command

void write_file(const char* path, const char* text) {
  const int fd = open(path, O_WRONLY);
  if (fd < 0 || write(fd, text, std::strlen(text)) < 0) fail(path);
  close(fd);
}

// The cable is pulled and put back: serial line and camera must come again, and pirvsd obeys.
void replug(const bsp::Pack& pack) {
  constexpr const char* kOff = "/sys/bus/usb/devices/1-0:1.0/usb1-port1/disable";
  write_file(kOff, "1");
  sleep(1);
  tell("replug.gone", access(kTty, F_OK) != 0);
  write_file(kOff, "0");
  for (int i = 0; i < 100 && access(kTty, F_OK) != 0; ++i) usleep(50'000);
  sleep(1);
  SerialPeer serial;
  serial.fd = open_tty(kTty);
  CameraPeer camera(pack);
  camera.open();
  camera.start();
  // What lay there from before we listened, and behind it a gap: the device had no room for more.
  for (int i = 0; i < 50; ++i) {
    usleep(20'000);
    serial.read_all();
    camera.read_all();
  }
  serial.poses = {};
  for (int i = 0; i < 125; ++i) {
    usleep(20'000);
    serial.read_all();
    camera.read_all();
  }
  tell("replug.lines", serial.poses.lines);
  tell("replug.missing", serial.poses.missing);
  tell("replug.same", camera.images());
  camera.stop();
  // Behind the end of what the terminal may have echoed before it was raw.
  serial.say("\nreset\nstop\n");
  for (int i = 0; i < 100; ++i) {
    usleep(20'000);
    serial.read_all();
  }
}

void play(const bsp::Pack& pack, double seconds) {
  const int network = open_network();
  SerialPeer serial;
  serial.fd = open_tty(kTty);
  CameraPeer camera(pack);
  camera.open();
  PoseCount poses;
  TimeNs first = 0;
  double first_bytes = 0;
  unsigned typed = 0, looks = 0, before_kill = 0;
  bool killed = false;
  for (bool ended = false; !ended;) {
    pollfd polled[3] = {{network, POLLIN, 0},
                        {serial.fd, POLLIN, 0},
                        {camera.streaming() ? camera.fd() : -1, POLLIN, 0}};
    (void)poll(polled, 3, 100);
    take_datagrams(network, poses);
    serial.read_all();
    camera.read_all();
    if (poses.lines > 0 && first == 0) {
      first = bsp::now();
      first_bytes = received_bytes();
    }
    const double t = first > 0 ? to_seconds(bsp::now() - first) : -1;
    if (looks == 0 && t > kLook_s) {
      camera.start();
      ++looks;
    }
    if (!killed && t > kKill_s) {
      before_kill = camera.images();
      killed = kill(find_process("pirvs-video"), SIGKILL) == 0;
      camera.allow_gap();
    }
    if (looks == 1 && t > kLookAway_s) {
      tell("video.before_kill", before_kill);
      tell("video.after_kill", camera.images() - before_kill);
      camera.stop();
      ++looks;
    }
    if (looks == 2 && t > kLookAgain_s) {
      camera.start();
      ++looks;
    }
    if (looks == 3 && t > kLookNoMore_s) {
      camera.stop();
      ++looks;
    }
    if (typed < std::size(kTyped) && t > (typed + 1) * kType_s) serial.say(kTyped[typed++]);
    ended = t > seconds;
  }
  const double lasted = to_seconds(bsp::now() - first);
  tell("killed", killed);
  tell("network.bytes_a_second", (received_bytes() - first_bytes) / lasted);
  camera.tell_all();
  poses.tell_all("network");
  serial.poses.tell_all("serial");
  camera.close();
  close(serial.fd);
  replug(pack);
}

// ---- costs -------------------------------------------------------------------------------------

// Seconds in which the machine had nothing to do, by the kernel's account.
double idle_s() {
  FILE* const in = std::fopen("/proc/stat", "r");
  double user = 0, nice = 0, system = 0, idle = 0;
  if (in == nullptr || std::fscanf(in, "cpu %lf %lf %lf %lf", &user, &nice, &system, &idle) != 4) {
    fail("/proc/stat");
  }
  std::fclose(in);
  return idle / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// The share of time in which this machine, which is device and PC in one, is not idle while it does
// `send` 200 times a second.
template <class Send>
double busy_while(Send&& send) {
  constexpr TimeNs kLasts = 5 * kSecond, kPeriod = kSecond / 200;
  const double idle = idle_s();
  const TimeNs begin = bsp::now();
  for (TimeNs t = begin; t < begin + kLasts; t += kPeriod) {
    const timespec until = {static_cast<time_t>(t / kSecond), t % kSecond};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    send(t);
  }
  return 1 - (idle_s() - idle) / to_seconds(bsp::now() - begin);
}

void put_pose_line(TextWriter& line, TimeNs t) {
  SE3 T_WB;
  T_WB.p = Vec3(1.25, -20.5, 0.0625);
  put_tum(line, t, T_WB);
  line.put(" tracking 0.99\n");
}

void measure_costs() {
  constexpr uint16_t kOther = kPort + 1;  // nobody reads there
  const double still = busy_while([](TimeNs) {});
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kOther);
  inet_aton(kHost, &to.sin_addr);
  const double datagrams = busy_while([&](TimeNs t) {
    Text<kPoseTextMax> line;
    put_pose_line(line, t);
    if (sendto(fd, line.c_str(), line.size(), 0, reinterpret_cast<const sockaddr*>(&to),
               sizeof to) < 0) {
      std::perror("sendto");
    }
  });
  const int tty = open_tty("/dev/ttyGS0");
  const double serial = busy_while([&](TimeNs t) {
    Text<kPoseTextMax> line;
    put_pose_line(line.put('#'), t);
    if (write(tty, line.c_str(), line.size()) < 0 && errno != EAGAIN) fail("write");
  });
  tell("cost.still", still);
  tell("cost.datagrams", datagrams - still);
  tell("cost.serial", serial - still);
}

}  // namespace
}  // namespace pirvs

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "cost") == 0) {
    pirvs::measure_costs();
    return 0;
  }
  if (argc < 3) return 2;
  // First, for the test's init waits for it.
  if (unshare(CLONE_NEWNET) != 0) pirvs::fail("unshare");
  close(open("/run/peer", O_WRONLY | O_CREAT, 0644));
  const int fd = open(argv[1], O_RDONLY);
  const off_t size = lseek(fd, 0, SEEK_END);
  void* const bytes = mmap(nullptr, static_cast<size_t>(size), PROT_READ, MAP_SHARED, fd, 0);
  static pirvs::bsp::Pack pack;
  if (bytes == MAP_FAILED || pack.open(bytes, static_cast<size_t>(size)) != pirvs::Status::kOk) {
    pirvs::fail("not a packed recording");
  }
  pirvs::play(pack, std::atof(argv[2]));
  return 0;
}
