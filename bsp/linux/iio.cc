#include "bsp/linux/iio.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmath>
#include <cstring>

#include "bsp/api/clock.h"
#include "bsp/linux/sysfs.h"
#include "core/base/number.h"
#include "core/base/text.h"

namespace pirvs::bsp {
namespace {

constexpr int kDevicesMax = 32;
constexpr int kTextMax = 128;
constexpr TimeNs kClockError_max = 1'000'000'000;
constexpr double kGapPeriods = 1.75;  // between the stamps of two samples that are neighbours
constexpr const char* kChannelNames[] = {"in_accel_x",   "in_accel_y",   "in_accel_z",
                                         "in_anglvel_x", "in_anglvel_y", "in_anglvel_z",
                                         "in_timestamp"};

std::string_view trimmed(const char* text) {
  std::string_view out(text);
  while (!out.empty() && (out.back() == '\n' || out.back() == ' ')) out.remove_suffix(1);
  return out;
}

// The names in an open folder, without the heap that readdir() needs: a device may come back at any
// time.
template <class Visit>
void for_each_file(int folder, Visit&& visit) {
  constexpr size_t kName = 19;  // of struct linux_dirent64: what stands before is 8, 8, 2 and 1
  constexpr size_t kSize = 16;
  alignas(8) char entries[2048];
  long got = 0;
  while ((got = syscall(SYS_getdents64, folder, entries, sizeof entries)) > 0) {
    for (long at = 0; at < got;) {
      uint16_t size = 0;
      std::memcpy(&size, entries + at + kSize, sizeof size);
      visit(entries + at + kName);
      at += size;
    }
  }
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// The number at `at`, which is then behind it.
bool take_number(const char*& at, int& out) {
  if (!is_digit(*at)) return false;
  for (out = 0; is_digit(*at) && out < 10'000; ++at) out = 10 * out + (*at - '0');
  return true;
}

bool take(const char*& at, const char* text) {
  const size_t size = std::strlen(text);
  if (std::strncmp(at, text, size) != 0) return false;
  at += size;
  return true;
}

}  // namespace

// ---- one element -------------------------------------------------------------------------------

bool read_element_type(const char* text, IioElement& out) {
  IioElement element = out;
  const char* at = text;
  element.big_endian = take(at, "be:");
  if (!element.big_endian && !take(at, "le:")) return false;
  element.is_signed = *at == 's';
  if (*at != 's' && *at != 'u') return false;
  ++at;
  int stored = 0;
  if (!take_number(at, element.bits) || !take(at, "/") || !take_number(at, stored)) return false;
  element.shift = 0;
  if (take(at, ">>") && !take_number(at, element.shift)) return false;
  element.bytes = stored / 8;
  const bool whole = stored == 8 || stored == 16 || stored == 32 || stored == 64;
  if (!whole || element.bits < 1 || element.bits + element.shift > stored) return false;
  out = element;
  return true;
}

int64_t read_element(const IioElement& element, const uint8_t* sample) {
  uint64_t value = 0;
  for (int i = 0; i < element.bytes; ++i) {
    const int at = element.big_endian ? i : element.bytes - 1 - i;
    value = value << 8 | sample[element.offset + at];
  }
  // The wanted bits to the top, and back down with the sign.
  value <<= 64 - element.bits - element.shift;
  return element.is_signed ? static_cast<int64_t>(value) >> (64 - element.bits)
                           : static_cast<int64_t>(value >> (64 - element.bits));
}

// ---- files of sysfs ----------------------------------------------------------------------------

bool IioImu::path_of(const char* file, char* out) const {
  TextWriter path(out, kPathMax);
  path.put(setup_.root).put("/sys/bus/iio/devices/iio:device").number(number_);
  path.put('/').put(file);
  return !path.full();
}

bool IioImu::read_file(const char* file, char* out, int max) const {
  char path[kPathMax];
  return path_of(file, path) && bsp::read_file(path, out, static_cast<size_t>(max));
}

// Keeps what stood there, for close().
bool IioImu::set_file(const char* file, const char* text) {
  char before[kTextMax];
  if (!read_file(file, before, kTextMax)) return false;
  if (trimmed(before) == text) return true;
  Saved& saved = saved_[saved_count_];
  if (saved_count_ == kSavedMax || trimmed(before).size() >= sizeof saved.text) return false;
  if (!path_of(file, saved.path)) return false;
  const std::string_view kept = trimmed(before);
  std::memcpy(saved.text, kept.data(), kept.size());
  saved.text[kept.size()] = 0;
  if (!write_file(saved.path, text)) return false;
  ++saved_count_;
  return true;
}

void IioImu::close() {
  // Last first: the buffer is off before its elements change. Then others may have the node.
  while (saved_count_ > 0) {
    const Saved& saved = saved_[--saved_count_];
    (void)write_file(saved.path, saved.text);  // an unplugged one has no files
  }
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

// ---- coming and going --------------------------------------------------------------------------

void IioImu::configure(const IioSetup& setup, const DeviceNews& news) {
  PIRVS_ASSERT(!is_open());
  setup_ = setup;
  teller_.configure(news);
}

Status IioImu::look_for_imu() {
  if (now() < retry_t_) return Status::kBusFault;
  retry_t_ = now() + kRetry_ns;
  const char* const why = open_imu();
  if (why != nullptr) {
    close();
    teller_.tell(setup_.device, why);
    return Status::kBusFault;
  }
  ++counters_.opened;
  bytes_here_ = bytes_at_ = 0;
  has_last_ = false;
  teller_.tell(setup_.device, "IMU started");
  return Status::kOk;
}

void IioImu::gone() {
  ++counters_.unplugged;
  close();
  retry_t_ = now() + kRetry_ns;
  teller_.tell(setup_.device, "IMU unplugged, waiting for it");
}

bool IioImu::find_device() {
  const char* name = setup_.device;
  (void)take(name, "iio:");
  const char* at = name;
  char text[kTextMax];
  if (take_number(at, number_) && *at == 0) return read_file("name", text, kTextMax);
  for (number_ = 0; number_ < kDevicesMax; ++number_) {
    if (read_file("name", text, kTextMax) && trimmed(text) == name) return true;
  }
  return false;
}

const char* IioImu::open_imu() {
  if (!find_device()) return "no such IMU, waiting for it";
  // The kernel lets one program have the node: without it nothing of another's is touched.
  if (const char* const why = open_node()) return why;
  // Nothing can be set while the buffer is on, left so by an earlier run.
  if (!set_file("buffer/enable", "0")) return "the IMU has no buffer, or no permission to use it";
  if (const char* const why = set_clock_and_rate()) return why;
  if (const char* const why = set_elements()) return why;
  if (const char* const why = lay_out()) return why;
  if (const char* const why = read_meaning()) return why;
  return start();
}

const char* IioImu::open_node() {
  Text<kPathMax> path;
  path.put(setup_.root).put("/dev/iio:device").number(number_);
  fd_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) {
    return errno == EBUSY ? "another program has the IMU, waiting for it"
                          : "the IMU's node cannot be opened";
  }
  return nullptr;
}

const char* IioImu::set_clock_and_rate() {
  if (!set_file("current_timestamp_clock", "monotonic")) {
    return "the IMU's stamps cannot be set to the monotonic clock";
  }
  Text<32> wanted;
  wanted.exact(setup_.rate_hz);
  // A driver without this file has one rate alone.
  const bool settable = set_file("sampling_frequency", wanted.c_str());
  char text[kTextMax];
  double rate_hz = 0;
  const bool told = read_file("sampling_frequency", text, kTextMax) &&
                    read_number(trimmed(text), rate_hz) && rate_hz > 0;
  if (told && !settable) return "the IMU refuses its rate";
  rate_hz_ = told ? rate_hz : setup_.rate_hz;
  return nullptr;
}

// Ours on, all others off: they would only take room.
const char* IioImu::set_elements() {
  char path[kPathMax];
  const int folder = path_of("scan_elements", path) ? open(path, O_RDONLY | O_DIRECTORY) : -1;
  if (folder < 0) return "the IMU has no scan elements";
  bool good = true;
  const auto set = [&](const char* file_name) {
    const std::string_view name(file_name);
    if (name.size() < 4 || std::memcmp(name.data() + name.size() - 3, "_en", 3) != 0) return;
    const std::string_view channel(name.data(), name.size() - 3);
    bool ours = false;
    for (const char* const wanted : kChannelNames) ours |= channel == wanted;
    Text<kTextMax> file;
    file.put("scan_elements/").put(file_name);
    good = set_file(file.c_str(), ours ? "1" : "0") && good;
  };
  for_each_file(folder, set);
  ::close(folder);
  return good ? nullptr : "the IMU refuses its scan elements";
}

// Elements lie in the order of their index, each at a multiple of its size.
const char* IioImu::lay_out() {
  constexpr const char* kNotThere = "not an IMU: force, rate or time is missing";
  for (int i = 0; i < kChannels; ++i) {
    IioElement& element = elements_[i];
    char text[kTextMax];
    Text<kTextMax> file;
    file.put("scan_elements/").put(kChannelNames[i]).put("_index");
    const char* at = text;
    if (!read_file(file.c_str(), text, kTextMax) || !take_number(at, element.index)) {
      return kNotThere;
    }
    file.clear();
    file.put("scan_elements/").put(kChannelNames[i]).put("_type");
    if (!read_file(file.c_str(), text, kTextMax) || !read_element_type(text, element)) {
      return kNotThere;
    }
  }
  int end = 0, widest = 1;
  for (int done = 0, after = -1; done < kChannels; ++done) {
    IioElement* next = nullptr;
    for (IioElement& element : elements_) {
      const bool later = element.index > after;
      if (later && (next == nullptr || element.index < next->index)) next = &element;
    }
    if (next == nullptr) return kNotThere;  // two have one index
    after = next->index;
    next->offset = (end + next->bytes - 1) / next->bytes * next->bytes;
    end = next->offset + next->bytes;
    widest = next->bytes > widest ? next->bytes : widest;
  }
  sample_bytes_ = (end + widest - 1) / widest * widest;
  return sample_bytes_ <= kSampleMax ? nullptr : kNotThere;
}

// "0, 1, 0; -1, 0, 0; 0, 0, 1"
bool IioImu::read_mount(const char* file, Mat3& out) const {
  char text[kTextMax];
  if (!read_file(file, text, kTextMax)) return false;
  double m[9];
  int count = 0;
  for (const char* at = text; count < 9;) {
    while (*at == ' ' || *at == ',' || *at == ';') ++at;
    const char* end = at;
    while (is_digit(*end) || *end == '-' || *end == '+' || *end == '.' || *end == 'e') ++end;
    if (!read_number({at, static_cast<size_t>(end - at)}, m[count])) return false;
    ++count;
    at = end;
  }
  for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = m[i];
  return true;
}

const char* IioImu::read_meaning() {
  const auto scale = [this](const char* file, double& out) {
    char text[kTextMax];
    return read_file(file, text, kTextMax) && read_number(trimmed(text), out) && out > 0;
  };
  const bool good =
      (scale("in_accel_scale", accel_scale_) || scale("in_accel_x_scale", accel_scale_)) &&
      (scale("in_anglvel_scale", gyro_scale_) || scale("in_anglvel_x_scale", gyro_scale_));
  if (!good) return "the IMU does not tell its scale";
  R_accel_ = R_gyro_ = Mat3::Identity();
  for (const char* const file : {"in_mount_matrix", "mount_matrix"}) {
    if (read_mount(file, R_accel_)) R_gyro_ = R_accel_;
  }
  (void)read_mount("in_accel_mount_matrix", R_accel_);
  (void)read_mount("in_anglvel_mount_matrix", R_gyro_);
  return nullptr;
}

const char* IioImu::start() {
  if (!set_file("buffer/length", "256")) return "the IMU refuses its buffer's length";
  (void)set_file("buffer/watermark", "1");  // kernels without one wake at each sample
  char text[kTextMax];
  if (read_file("trigger/current_trigger", text, kTextMax) && trimmed(text).empty()) {
    return "the IMU has no trigger: write one to trigger/current_trigger";
  }
  return set_file("buffer/enable", "1") ? nullptr : "the IMU refuses to start";
}

// ---- samples -----------------------------------------------------------------------------------

Status IioImu::refill() {
  // A node gives whole samples; what is left of one is kept all the same.
  const int rest = bytes_here_ - bytes_at_;
  std::memmove(bytes_, bytes_ + bytes_at_, static_cast<size_t>(rest));
  bytes_at_ = 0;
  bytes_here_ = rest;
  const auto room = static_cast<size_t>(kSamples * sample_bytes_ - rest);
  const ssize_t got = read(fd_, bytes_ + rest, room);
  if (got > 0) {
    bytes_here_ += static_cast<int>(got);
    return Status::kOk;
  }
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return Status::kEmpty;
  gone();
  return Status::kBusFault;
}

Status IioImu::decode(const uint8_t* bytes, ImuSample& out) {
  out = ImuSample{};
  const TimeNs stamp = read_element(elements_[kTime], bytes);
  for (int i = 0; i < 3; ++i) {
    out.f_B(i) = static_cast<double>(read_element(elements_[i], bytes)) * accel_scale_;
    out.w_B(i) = static_cast<double>(read_element(elements_[3 + i], bytes)) * gyro_scale_;
  }
  out.f_B = R_accel_ * out.f_B;
  out.w_B = R_gyro_ * out.w_B;
  out.t = stamp - setup_.delay_ns;
  const TimeNs off = now() - stamp;
  if (off > kClockError_max || off < -kClockError_max) {
    ++counters_.wrong_clock;
    teller_.tell(setup_.device, "the IMU's stamps are not of the monotonic clock");
    return Status::kBadData;
  }
  ++counters_.samples;
  const double periods = has_last_ ? to_seconds(stamp - last_t_) * rate_hz_ : 0;
  last_t_ = stamp;
  has_last_ = true;
  if (periods < kGapPeriods) return Status::kOk;
  counters_.lost += static_cast<uint32_t>(periods + 0.5) - 1;
  return Status::kFull;
}

Status IioImu::poll(ImuSample& out) {
  if (!is_open() && look_for_imu() != Status::kOk) return gone_.answer();
  if (bytes_here_ - bytes_at_ < sample_bytes_) {
    PIRVS_TRY(refill());
    if (bytes_here_ < sample_bytes_) return Status::kEmpty;
  }
  const uint8_t* const bytes = bytes_ + bytes_at_;
  bytes_at_ += sample_bytes_;
  return decode(bytes, out);
}

}  // namespace pirvs::bsp
