// What stands at the other end of the device's pins: puts edges on SYNC_IN and turns a wheel, and
// writes down when the kernel saw SYNC_OUT, HEALTH and TRIGGER change.
// usage: robot SECONDS SYNC_PERIOD_US WHEEL_PERIOD_US [pps], times of this guest; 0: that one
//        rests. With pps it asks how pirvsd sees the clock that SYNC_IN is the pulse of.
//        robot hog: takes all memory that there is
// Out     On standard output: "sync T", the time chosen for a rising edge of SYNC_IN, "wheel TICKS"
//         turned in all, "SYNC_OUT T LEVEL", HEALTH and TRIGGER likewise, "lost N" edges that it
//         missed, "pps T RATE_PPB NOISE_NS PULSES ODD" of the stream.
#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "modules/stream/stream.h"

namespace {

// Lines of test_gpio.c, and what its outputs are wired to.
enum Line : uint32_t {
  kSyncIn = 5,
  kLeftA = 6,
  kLeftB = 7,
  kSyncOut = 3 + 16,
  kHealth = 4 + 16,
  kTrigger = 11 + 16
};
constexpr int64_t kMilli = 1'000'000, kSecond = 1'000'000'000;

struct Level {
  int64_t t_ns;
  uint32_t line, high;
};

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

int64_t now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

// The chip with that label.
int open_chip(const char* label) {
  for (int i = 0; i < 16; ++i) {
    char path[32];
    std::snprintf(path, sizeof path, "/dev/gpiochip%d", i);
    const int fd = open(path, O_RDWR);
    gpiochip_info info{};
    if (fd >= 0 && ioctl(fd, GPIO_GET_CHIPINFO_IOCTL, &info) == 0 &&
        std::strcmp(info.label, label) == 0) {
      return fd;
    }
    close(fd);
  }
  fail(label);
}

int listen() {
  const int chip = open_chip("test_gpio");
  gpio_v2_line_request request{};
  request.offsets[0] = kSyncOut;
  request.offsets[1] = kHealth;
  request.offsets[2] = kTrigger;
  request.num_lines = 3;
  request.event_buffer_size = 1024;
  request.config.flags =
      GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING | GPIO_V2_LINE_FLAG_EDGE_FALLING;
  if (ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request) != 0) fail("lines");
  fcntl(request.fd, F_SETFL, O_NONBLOCK);
  return request.fd;
}

const char* name_of(uint32_t line) {
  if (line == kTrigger) return "TRIGGER";
  return line == kSyncOut ? "SYNC_OUT" : "HEALTH";
}

void note(int fd, uint32_t& seen, uint32_t& lost) {
  gpio_v2_line_event event;
  while (read(fd, &event, sizeof event) == sizeof event) {
    lost += event.seqno - seen - 1;
    seen = event.seqno;
    std::printf("%s %lld %d\n", name_of(event.offset), static_cast<long long>(event.timestamp_ns),
                event.id == GPIO_V2_LINE_EVENT_RISING_EDGE);
  }
}

// The edges of both inputs up to a time, in order.
class Player {
 public:
  Player(int64_t t, int64_t sync_period, int64_t wheel_period)
      : sync_t_(t), wheel_t_(t + 7), sync_period_(sync_period), wheel_period_(wheel_period) {
    fd_ = open("/dev/test_gpio", O_WRONLY);
    if (fd_ < 0) fail("/dev/test_gpio");
  }

  void play(int64_t until) {
    for (;;) {
      const int64_t sync = sync_period_ > 0 ? sync_t_ : INT64_MAX;
      const int64_t wheel = wheel_period_ > 0 ? wheel_t_ : INT64_MAX;
      if (sync >= until && wheel >= until) return;
      if (sync <= wheel) {
        high_ = !high_;
        put({sync, kSyncIn, high_});
        if (high_) std::printf("sync %lld\n", static_cast<long long>(sync));
        sync_t_ += sync_period_ / 2;
      } else {
        // A up, B up, A down, B down.
        put({wheel, ticks_ & 1 ? kLeftB : kLeftA, (ticks_ & 3) < 2});
        ++ticks_;
        wheel_t_ += wheel_period_;
      }
    }
  }
  unsigned ticks() const { return ticks_; }

 private:
  void put(const Level& level) {
    if (write(fd_, &level, sizeof level) != sizeof level) fail("an edge");
  }

  int fd_;
  int64_t sync_t_, wheel_t_, sync_period_, wheel_period_;
  bool high_ = false;
  unsigned ticks_ = 0;
};

// What the stream tells of the external clock.
class ClockListener {
 public:
  explicit ClockListener(bool wanted) : fd_(wanted ? socket(AF_INET, SOCK_DGRAM, 0) : -1) {
    sockaddr_in device{};
    device.sin_family = AF_INET;
    device.sin_port = htons(14560);
    device.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (wanted && connect(fd_, reinterpret_cast<sockaddr*>(&device), sizeof device) != 0) {
      fail("stream");
    }
  }

  void poll(int64_t t) {
    if (fd_ < 0) return;
    uint8_t bytes[pirvs::stream::kMax];
    if (t >= ask_t_) {
      ask_t_ = t + kSecond;
      const pirvs::stream::SubscribeMessage ask = {bit(pirvs::stream::Kind::kPps), 3};
      (void)!send(fd_, bytes, encode(ask, bytes), MSG_DONTWAIT);
    }
    ssize_t size = 0;
    while ((size = recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT)) > 0) {
      pirvs::stream::Header header;
      pirvs::stream::PpsMessage pps;
      if (!decode(bytes, static_cast<size_t>(size), header) ||
          !decode(header, bytes + pirvs::stream::kHeaderBytes, pps)) {
        continue;
      }
      std::printf("pps %lld %.1f %.1f %u %u\n", static_cast<long long>(pps.t), pps.rate_ppb,
                  static_cast<double>(pps.noise_ns), pps.pulses, pps.odd);
    }
  }

 private:
  int fd_;
  int64_t ask_t_ = 0;
};

[[noreturn]] void take_all_memory() {
  constexpr size_t kPiece = 1 << 20;
  for (;;) {
    void* const piece = std::malloc(kPiece);
    if (piece != nullptr) std::memset(piece, 1, kPiece);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "hog") == 0) take_all_memory();
  const bool pps = argc == 5 && std::strcmp(argv[4], "pps") == 0;
  if (argc != 4 && !pps) return 2;
  const int64_t begin = now() + 500 * kMilli;
  const int64_t end = begin + static_cast<int64_t>(std::atof(argv[1]) * kSecond);
  const sched_param urgent{47};
  if (sched_setscheduler(0, SCHED_FIFO, &urgent) != 0) std::perror("no priority");
  const int fd = listen();
  Player player(begin, 1000 * std::atoll(argv[2]), 1000 * std::atoll(argv[3]));
  ClockListener clock(pps);
  uint32_t seen = 0, lost = 0;
  for (int64_t t = now(); t < end; t = now()) {
    player.play(t + 300 * kMilli < end ? t + 300 * kMilli : end);
    pollfd ready{fd, POLLIN, 0};
    poll(&ready, 1, 100);
    note(fd, seen, lost);
    clock.poll(t);
  }
  // It still watches when pirvsd ends.
  for (const int64_t watched = now() + 3 * kSecond; now() < watched;) {
    pollfd ready{fd, POLLIN, 0};
    poll(&ready, 1, 100);
    note(fd, seen, lost);
  }
  std::printf("wheel %u\nlost %u\n", player.ticks(), lost);
  const sched_param none{0};
  (void)sched_setscheduler(0, SCHED_OTHER, &none);
  return 0;
}
