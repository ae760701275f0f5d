// Plays a packed recording through the test modules, as sensors would: each IMU sample is measured
// at its time, each pair of images comes kTransfer_ns after the middle of its exposure.
// usage: feeder PACK [faults] [icm20602] [grid] [loop SECONDS]. With grid, the first image is of a
// whole multiple of kGrid_ns. With faults, what kFaults lists goes wrong. In a loop what comes
// kLoopFrom_ns after its start is played again and again, for so long: a flight in circles goes on,
// and rest does. Runs above pirvsd and below the kernel's threads for interrupts, which else would
// miss edges.
// Out     On standard output: "shift NS", what was added to the recording's time, a whole number of
//         microseconds, since V4L2 stamps have no more; "fed F frames S samples, R refused, C
//         clipped" at the end. The scale is the driver's, so values are multiples of it; that of
//         the ICM-20602, which has none, as pirvsd sets it up.
#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"
#include "bsp/replay/pack.h"

namespace pirvs {
namespace {

constexpr TimeNs kLead_ns = 2'000'000'000;  // from now to the first item
constexpr TimeNs kTransfer_ns = 5'000'000;
constexpr TimeNs kGrid_ns = 50'000'000;
constexpr TimeNs kMicro = 1'000;

enum What : uint32_t { kGood, kBad, kPull, kPlug, kStall };  // as test_camera.c has them

struct Shot {
  uint64_t stamp_ns;
  uint32_t skip, what;
};

// What happens at a frame, and to which cameras, a bit each.
enum class Fault : uint8_t {
  kNone,
  kMissing,
  kDamaged,
  kPulled,
  kPlugged,
  kImuPulled,
  kImuPlugged,
  kStalled,
  kDark
};
struct FaultAt {
  uint32_t frame;
  Fault what;
  uint8_t cameras;
};
constexpr FaultAt kFaults[] = {
    {30, Fault::kMissing, 2},                               // half a pair
    {40, Fault::kDamaged, 1},                               // likewise
    {50, Fault::kMissing, 3},                               // a whole one
    {60, Fault::kPulled, 3},                                // both cameras, and back after 0.8 s
    {76, Fault::kPlugged, 3},                               //
    {88, Fault::kImuPulled, 0},                             // and back after 0.3 s
    {94, Fault::kImuPlugged, 0}, {98, Fault::kStalled, 1},  // until its stream is started anew
    {150, Fault::kDark, 3},                                 // to the end
};
bool with_faults = false, icm20602 = false, on_grid = false;
double loop_s = 0;

Fault fault_at(uint32_t frame, int camera) {
  for (const FaultAt& fault : kFaults) {
    const bool here = fault.cameras == 0 ? camera == 0 : (fault.cameras >> camera & 1) != 0;
    const bool now = fault.frame == frame || (fault.what == Fault::kDark && fault.frame < frame);
    if (with_faults && now && here) return fault.what;
  }
  return Fault::kNone;
}

struct Sample {
  int64_t t_ns;
  int16_t force[3], temperature, rate[3], fault;
};

// Of the ICM-20602, at a time since the first sample: as test_imu.c has them.
enum ImuFault : int16_t { kBusDead = 1, kBusGood, kSilent, kSilentGood, kReset };
struct ImuFaultAt {
  TimeNs after_ns;
  ImuFault what;
};
constexpr TimeNs kSecond = 1'000'000'000;
constexpr ImuFaultAt kImuFaults[] = {
    {kSecond * 20 / 10, kBusDead},
    {kSecond * 20 / 10 + 30'000'000, kBusGood},  // its samples wait in the FIFO
    {kSecond * 30 / 10, kReset},
    {kSecond * 40 / 10, kSilent},  // and lost data-ready edges
    {kSecond * 40 / 10 + 200'000'000, kSilentGood},
    {kSecond * 50 / 10, kBusDead},  // until the FIFO runs over
    {kSecond * 50 / 10 + 600'000'000, kBusGood},
};

struct Fed {
  unsigned frames = 0, samples = 0, refused = 0, clipped = 0;
};

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

double read_scale(const char* file) {
  FILE* const in = std::fopen(file, "r");
  double scale = 0;
  if (in == nullptr || std::fscanf(in, "%lf", &scale) != 1) fail(file);
  std::fclose(in);
  return scale;
}

int16_t counts_of(double value, double scale, Fed& fed) {
  const long counts = std::lround(value / scale);
  const long kept = counts < INT16_MIN ? INT16_MIN : counts > INT16_MAX ? INT16_MAX : counts;
  fed.clipped += kept != counts;
  return static_cast<int16_t>(kept);
}

// A recording whose part [from, end) is played `count` times.
struct Loops {
  static constexpr TimeNs kLoopFrom_ns = 2'000'000'000;
  int count = 1;
  TimeNs from = 0, end = INT64_MAX;
};

// Whole periods of the images, so that their rhythm goes on.
Loops loops_for(const bsp::Pack& pack, double seconds) {
  Loops out;
  const uint32_t frames = pack.header().frame_count;
  uint32_t first = 0;
  while (first + 2 < frames && pack.frame(first).t < pack.frame(0).t + Loops::kLoopFrom_ns) ++first;
  out.from = pack.frame(first).t;
  out.end = 2 * pack.frame(frames - 1).t - pack.frame(frames - 2).t;
  const double round_s = to_seconds(out.end - out.from);
  const double once_s = to_seconds(out.end - pack.frame(0).t);
  if (seconds > once_s) out.count += static_cast<int>((seconds - once_s) / round_s + 1);
  return out;
}

// One stream of the recording, item by item, through all rounds.
class Cursor {
 public:
  Cursor(uint32_t total, const Loops& loops) : total_(total), loops_(loops) {}
  template <class TimeOf>
  bool next(TimeOf time_of, uint32_t& index, TimeNs& t) {
    const bool more_rounds = round_ + 1 < loops_.count;
    if (more_rounds && (at_ == total_ || time_of(at_) >= loops_.end)) {
      ++round_;
      at_ = 0;
      while (time_of(at_) < loops_.from) ++at_;
    }
    if (at_ == total_) return false;
    index = at_++;
    t = time_of(index) + round_ * (loops_.end - loops_.from);
    return true;
  }

 private:
  uint32_t total_, at_ = 0;
  int round_ = 0;
  Loops loops_;
};

class ImuFeed {
 public:
  ImuFeed(const bsp::Pack& pack, const Loops& loops, TimeNs shift)
      : pack_(pack), cursor_(pack.header().imu_count, loops), shift_(shift) {
    constexpr double kPi = 3.14159265358979323846;
    force_ = icm20602 ? 8.0 / 32768 * 9.80665
                      : read_scale("/sys/bus/iio/devices/iio:device0/in_accel_scale");
    rate_ = icm20602 ? 2000.0 / 32768 * kPi / 180
                     : read_scale("/sys/bus/iio/devices/iio:device0/in_anglvel_scale");
    fd_ = open("/dev/test_imu", O_WRONLY);
    if (fd_ < 0) fail("/dev/test_imu");
    if (!icm20602 || !with_faults) fault_ = std::size(kImuFaults);
  }

  // All samples up to a time of the recording.
  void feed(TimeNs until, Fed& fed) {
    while (ahead_t_ <= until) {
      uint32_t index = 0;
      TimeNs t = 0;
      if (!cursor_.next([this](uint32_t i) { return pack_.imu(i).t; }, index, t)) return;
      ahead_t_ = t;
      feed_one(pack_.imu(index), t, fed);
    }
  }
  TimeNs ahead() const { return ahead_t_; }  // of the last sample

 private:
  void put(const Sample& sample) const {
    if (write(fd_, &sample, sizeof sample) != sizeof sample) fail("a sample");
  }

  void feed_one(const ImuSample& in, TimeNs t, Fed& fed) {
    Sample out{};
    const TimeNs begin = pack_.imu(0).t;
    while (fault_ < std::size(kImuFaults) && t > begin + kImuFaults[fault_].after_ns) {
      out.t_ns = begin + kImuFaults[fault_].after_ns + shift_;
      out.fault = kImuFaults[fault_++].what;
      put(out);
      out.fault = 0;
    }
    out.t_ns = t + shift_;
    for (int k = 0; k < 3; ++k) {
      out.force[k] = counts_of(in.f_B(k), force_, fed);
      out.rate[k] = counts_of(in.w_B(k), rate_, fed);
    }
    put(out);
    ++fed.samples;
  }

  const bsp::Pack& pack_;
  Cursor cursor_;
  TimeNs shift_, ahead_t_ = INT64_MIN;
  double force_ = 0, rate_ = 0;
  int fd_ = -1;
  size_t fault_ = 0;
};

void write_file(const char* path, const char* text) {
  const int fd = open(path, O_WRONLY);
  if (fd < 0 || write(fd, text, std::strlen(text)) < 0) std::perror(path);
  close(fd);
}

// One camera's node for tests, and what its sensor has counted without showing it.
struct TestCamera {
  int fd = -1;
  size_t bytes = 0;
  uint32_t skip = 0;

  bool show(TimeNs stamp, What what, const uint8_t* pixels) {
    static uint8_t message[sizeof(Shot) + kImagePixelsMax];
    const Shot shot = {static_cast<uint64_t>(stamp), skip, what};
    skip = 0;
    std::memcpy(message, &shot, sizeof shot);
    std::memcpy(message + sizeof shot, pixels, bytes);
    const size_t size = sizeof shot + bytes;
    return write(fd, message, size) == static_cast<ssize_t>(size);
  }
  void plug(What what) const {
    const Shot shot = {0, 1, what};
    if (write(fd, &shot, sizeof shot) != sizeof shot) std::perror("plug");
  }
};

void feed_image(TestCamera& camera, Fault fault, TimeNs stamp, const uint8_t* pixels, Fed& fed) {
  constexpr const char* kDriver = "/sys/bus/i2c/drivers/inv-mpu6050-i2c/";
  constexpr const char* kChip = "0-0068";
  char path[80];
  if (fault == Fault::kPulled) camera.plug(kPull);
  if (fault == Fault::kPlugged) camera.plug(kPlug);
  if (fault == Fault::kStalled) camera.plug(kStall);
  if (!icm20602 && (fault == Fault::kImuPulled || fault == Fault::kImuPlugged)) {
    std::snprintf(path, sizeof path, "%s%s", kDriver,
                  fault == Fault::kImuPulled ? "unbind" : "bind");
    write_file(path, kChip);
  }
  if (fault == Fault::kMissing) {
    ++camera.skip;
    return;
  }
  static const uint8_t kBlack[kImagePixelsMax] = {};
  fed.refused += !camera.show(stamp, fault == Fault::kDamaged ? kBad : kGood,
                              fault == Fault::kDark ? kBlack : pixels);
}

void feed_all(const bsp::Pack& pack, const Loops& loops, TimeNs shift, Fed& fed) {
  constexpr TimeNs kAhead_ns = 1'000'000'000;  // of the IMU, whose samples wait for their time
  ImuFeed imu(pack, loops, shift);
  TestCamera cameras[kCamerasMax];
  for (int c = 0; c < kCamerasMax; ++c) {
    char node[32];
    std::snprintf(node, sizeof node, "/dev/test_camera%d", c);
    cameras[c].fd = open(node, O_WRONLY);
    if (cameras[c].fd < 0) fail(node);
    const Camera camera = pack.camera(c);
    cameras[c].bytes = static_cast<size_t>(camera.width * camera.height);
  }
  // Left from before the stream began, in one camera alone.
  constexpr TimeNs kHour_ns = 3'600'000'000'000;
  if (with_faults) (void)cameras[1].show(bsp::now() - kHour_ns, kGood, pack.frame(0).image[1].data);
  Cursor cursor(pack.header().frame_count, loops);
  uint32_t index = 0;
  TimeNs t = 0;
  while (cursor.next([&](uint32_t i) { return pack.frame(i).t; }, index, t)) {
    const StereoFrame frame = pack.frame(index);
    imu.feed(t + kAhead_ns, fed);
    bsp::sleep_until(t + shift + kTransfer_ns);
    for (int c = 0; c < kCamerasMax; ++c) {
      feed_image(cameras[c], fault_at(fed.frames, c), t + shift, frame.image[c].data, fed);
    }
    ++fed.frames;
  }
  imu.feed(INT64_MAX, fed);
  constexpr TimeNs kAfter_ns = 100'000'000;
  bsp::sleep_until(imu.ahead() + shift + kAfter_ns);
}

int feed(const char* path) {
  const int fd = open(path, O_RDONLY);
  const off_t size = lseek(fd, 0, SEEK_END);
  if (fd < 0 || size <= 0) fail(path);
  void* const bytes = mmap(nullptr, static_cast<size_t>(size), PROT_READ, MAP_SHARED, fd, 0);
  bsp::Pack pack;
  if (bytes == MAP_FAILED || pack.open(bytes, static_cast<size_t>(size)) != Status::kOk) {
    fail("not a packed recording");
  }
  // Not before: to look through a pack takes 0.2 s, in which nothing of pirvsd would run.
  const sched_param urgent{46};
  if (sched_setscheduler(0, SCHED_FIFO, &urgent) != 0) std::perror("no priority");
  const TimeNs begin = pack.imu(0).t < pack.frame(0).t ? pack.imu(0).t : pack.frame(0).t;
  TimeNs shift = (bsp::now() + kLead_ns - begin) / kMicro * kMicro;
  if (on_grid) shift += (kGrid_ns - (pack.frame(0).t + shift) % kGrid_ns) / kMicro * kMicro;
  std::printf("shift %lld\n", static_cast<long long>(shift));
  std::fflush(stdout);
  Fed fed;
  feed_all(pack, loops_for(pack, loop_s), shift, fed);
  std::printf("fed %u frames %u samples, %u refused, %u clipped\n", fed.frames, fed.samples,
              fed.refused, fed.clipped);
  return 0;
}

}  // namespace
}  // namespace pirvs

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  for (int i = 2; i < argc; ++i) {
    pirvs::with_faults |= std::strcmp(argv[i], "faults") == 0;
    pirvs::icm20602 |= std::strcmp(argv[i], "icm20602") == 0;
    pirvs::on_grid |= std::strcmp(argv[i], "grid") == 0;
    const bool loop = std::strcmp(argv[i], "loop") == 0 && i + 1 < argc;
    if (loop) pirvs::loop_s = std::atof(argv[i + 1]);
  }
  const int status = pirvs::feed(argv[1]);
  const sched_param none{0};  // to give memory back takes long, and others wait
  (void)sched_setscheduler(0, SCHED_OTHER, &none);
  return status;
}
