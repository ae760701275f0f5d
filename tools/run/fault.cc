#include "tools/run/fault.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kTime_s_max = 1e6;
constexpr TimeNs kStampBack = 100'000'000;
constexpr size_t kSpikeEvery = 10;
// Full scale of common IMUs: 2000 deg/s, 16 g.
constexpr double kFullRate_rad_s = 34.9, kFullForce_m_s2 = 156.9;

enum class Takes : uint8_t { kTime, kTimeAndValue, kValue };
enum class Alone : uint8_t { kOneItem, kFromThereOn };  // what a time "A" without an end means

struct Row {
  const char* name;
  FaultKind kind;
  Takes takes;
  Alone alone;
  double min, max;  // of the value
  const char* example;
  const char* meaning;
};

constexpr Row kRows[] = {
    {"cam0", FaultKind::kCam0, Takes::kTime, Alone::kFromThereOn, 0, 0, "cam0:7-12",
     "no images from the left camera"},
    {"cam1", FaultKind::kCam1, Takes::kTime, Alone::kFromThereOn, 0, 0, "cam1:5-10",
     "no images from the right camera"},
    {"black", FaultKind::kBlack, Takes::kTime, Alone::kFromThereOn, 0, 0, "black:20-21",
     "both images all black"},
    {"white", FaultKind::kWhite, Takes::kTime, Alone::kFromThereOn, 0, 0, "white:20-21",
     "both images all white"},
    {"frozen", FaultKind::kFrozen, Takes::kTime, Alone::kFromThereOn, 0, 0, "frozen:20-21",
     "both cameras repeat their last image under new stamps"},
    {"gain", FaultKind::kGain, Takes::kTimeAndValue, Alone::kFromThereOn, 0.01, 100, "gain:18x4",
     "the brightness of both images changes by this factor"},
    {"frames", FaultKind::kFrames, Takes::kValue, Alone::kFromThereOn, 0, 1, "frames:0.1",
     "this share of the frames is lost, at random with a fixed seed"},
    {"late", FaultKind::kLate, Takes::kTime, Alone::kOneItem, 0, 0, "late:8",
     "the right camera delivers its previous image, under that image's stamp"},
    {"imu", FaultKind::kImu, Takes::kTime, Alone::kFromThereOn, 0, 0, "imu:30-30.1",
     "no IMU samples"},
    {"nan", FaultKind::kNan, Takes::kTime, Alone::kOneItem, 0, 0, "nan:15",
     "an IMU sample that is NaN"},
    {"spike", FaultKind::kSpike, Takes::kTime, Alone::kOneItem, 0, 0, "spike:15",
     "an IMU sample that reads 30 rad/s and -150 m/s^2; A-B: every tenth"},
    {"saturate", FaultKind::kSaturate, Takes::kTime, Alone::kOneItem, 0, 0, "saturate:15-15.2",
     "the IMU reads full scale on every axis, 2000 deg/s and 16 g"},
    {"stuck", FaultKind::kStuck, Takes::kTime, Alone::kFromThereOn, 0, 0, "stuck:15-16",
     "the IMU repeats its last sample under new stamps"},
    {"stamp", FaultKind::kStamp, Takes::kTime, Alone::kOneItem, 0, 0, "stamp:12",
     "a frame and an IMU sample are stamped 0.1 s too early"},
    {"clock", FaultKind::kClock, Takes::kTimeAndValue, Alone::kFromThereOn, -1e5, 1e5, "clock:12x5",
     "the clock of all sensors jumps by this many seconds"},
    {"clock-imu", FaultKind::kClockImu, Takes::kTimeAndValue, Alone::kFromThereOn, -1e5, 1e5,
     "clock-imu:12x-2", "the clock of the IMU alone jumps by this many seconds"},
    {"clock-cam", FaultKind::kClockCam, Takes::kTimeAndValue, Alone::kFromThereOn, -1e5, 1e5,
     "clock-cam:12x5", "the clock of the cameras alone jumps by this many seconds"},
};
static_assert(std::size(kRows) == static_cast<size_t>(FaultKind::kCount));

[[noreturn]] void refuse(const std::string& what, const std::string& spec, const Row& row) {
  throw InputError(what, "--fault " + spec, std::string("write it like ") + row.example);
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) return std::nullopt;
  return value;
}

const Row& row_of(std::string_view name, const std::string& spec) {
  std::string known;
  for (const Row& row : kRows) {
    if (name == row.name) return row;
    known += std::string(known.empty() ? "" : " ") + row.name;
  }
  throw InputError("no such fault", "--fault " + spec, "there are: " + known);
}

void parse_time(std::string_view text, const Row& row, Fault& fault) {
  const size_t dash = text.find('-', 1);
  const auto begin = number(text.substr(0, dash));
  if (!begin || *begin < 0 || *begin > kTime_s_max) {
    refuse("the time is not in seconds after the first frame", fault.spec, row);
  }
  fault.begin = from_seconds(*begin);
  fault.once = dash == std::string_view::npos && row.alone == Alone::kOneItem;
  if (dash == std::string_view::npos) return;
  const auto end = number(text.substr(dash + 1));
  if (end && *end >= 0 && *end <= kTime_s_max) fault.end = from_seconds(*end);
  if (!end || *end < 0 || *end > kTime_s_max || fault.end <= fault.begin) {
    refuse("the time does not end after it begins", fault.spec, row);
  }
}

// Every pixel row by row, whatever its stride, and the view on them.
void copy(const ImageView& image, std::vector<uint8_t>& pixels) {
  if (image.data == pixels.data()) return;
  pixels.resize(size_t(image.width) * size_t(image.height));
  for (int y = 0; y < image.height; ++y) {
    std::copy_n(image.row(y), image.width, pixels.begin() + ptrdiff_t(y) * image.width);
  }
}

}  // namespace

Fault parse_fault(const std::string& spec) {
  Fault fault;
  fault.spec = spec;
  const std::string_view text = spec;
  const size_t colon = text.find(':');
  const Row& row = row_of(text.substr(0, colon), spec);
  if (colon == std::string_view::npos) refuse("a fault needs a time or a share", spec, row);
  fault.kind = row.kind;
  std::string_view when = text.substr(colon + 1);
  std::string_view factor = when;
  if (row.takes == Takes::kTimeAndValue) {
    const size_t x = when.find('x');
    if (x == std::string_view::npos) refuse("the value behind 'x' is missing", spec, row);
    factor = when.substr(x + 1);
    when = when.substr(0, x);
  }
  if (row.takes != Takes::kTime) {
    const auto value = number(factor);
    if (!value || *value < row.min || *value > row.max) {
      char range[64];
      std::snprintf(range, sizeof range, "the value is not within %g to %g", row.min, row.max);
      refuse(range, spec, row);
    }
    fault.value = *value;
  }
  if (row.takes != Takes::kValue) parse_time(when, row, fault);
  return fault;
}

std::string fault_help() {
  std::string out =
      "Faults (--fault SPEC, repeatable; seconds after the first frame, A-B or from A on):\n";
  for (const Row& row : kRows) {
    char line[160];
    std::snprintf(line, sizeof line, "  %-18s %s\n", row.example, row.meaning);
    out += line;
  }
  return out;
}

FaultLine::FaultLine(const std::vector<Fault>& faults, const Recording& recording)
    : first_frame_(recording.frames.front().t),
      camera_time_offset_(recording.calibration.camera_time_offset_ns) {
  const TimeNs length = recording.frames.back().t - first_frame_;
  for (const Fault& fault : faults) {
    if (fault.begin > length) {
      throw InputError("the recording ends before this fault", "--fault " + fault.spec,
                       "it lasts " + std::to_string(to_seconds(length)) + " s");
    }
    stages_.emplace_back();
    stages_.back().fault = fault;
  }
}

bool FaultLine::hits(Stage& stage, TimeNs since_begin, bool& done) {
  if (since_begin < stage.fault.begin || since_begin >= stage.fault.end || done) return false;
  done = stage.fault.once;
  return true;
}

bool FaultLine::pass(ImuSample& sample) {
  const TimeNs since = sample.t - camera_time_offset_ - first_frame_;
  for (Stage& stage : stages_) {
    if (since < stage.fault.begin) {
      stage.held = sample;
      stage.has_held = true;
    }
    if (hits(stage, since, stage.imu_done) && !break_sample(stage, sample)) return false;
  }
  return true;
}

bool FaultLine::break_sample(Stage& stage, ImuSample& sample) {
  switch (stage.fault.kind) {
    case FaultKind::kImu:
      ++stage.applied;
      return false;
    case FaultKind::kNan:
      sample.w_B.x() = sample.f_B.z() = std::numeric_limits<double>::quiet_NaN();
      break;
    case FaultKind::kSpike:
      if (stage.seen++ % kSpikeEvery != 0) return true;
      sample.w_B.x() = 30;
      sample.f_B.z() = -150;
      break;
    case FaultKind::kSaturate:
      for (int i = 0; i < 3; ++i) {
        sample.w_B[i] = std::copysign(kFullRate_rad_s, sample.w_B[i]);
        sample.f_B[i] = std::copysign(kFullForce_m_s2, sample.f_B[i]);
      }
      break;
    case FaultKind::kStuck:
      if (!stage.has_held) return true;
      sample.w_B = stage.held.w_B;
      sample.f_B = stage.held.f_B;
      break;
    case FaultKind::kStamp:
      sample.t -= kStampBack;
      break;
    case FaultKind::kClock:
    case FaultKind::kClockImu:
      sample.t += from_seconds(stage.fault.value);
      break;
    default:
      return true;
  }
  ++stage.applied;
  return true;
}

bool FaultLine::pass(StereoFrame& frame) {
  const TimeNs since = frame.t - first_frame_;
  for (Stage& stage : stages_) {
    const bool hit = hits(stage, since, stage.frame_done);
    const bool history =
        stage.fault.kind == FaultKind::kLate || (stage.fault.kind == FaultKind::kFrozen && !hit);
    const StereoFrame whole = frame;
    for (int c = 0; history && c < kCamerasMax; ++c) {
      if ((whole.present >> c & 1) != 0) copy(whole.image[c], stage.next_pixels[c]);
    }
    if (hit && !break_frame(stage, frame)) return false;
    if (!history) continue;
    for (int c = 0; c < kCamerasMax; ++c) {
      if ((whole.present >> c & 1) != 0) std::swap(stage.held_pixels[c], stage.next_pixels[c]);
    }
    stage.held_t = whole.t;
    stage.held_present = whole.present;
  }
  return true;
}

bool FaultLine::break_frame(Stage& stage, StereoFrame& frame) {
  const auto drop_camera = [&](int c) {
    stage.applied += frame.present >> c & 1;
    frame.present &= uint8_t(~(1u << c));
    frame.image[c] = ImageView{};
    return true;
  };
  switch (stage.fault.kind) {
    case FaultKind::kCam0:
      return drop_camera(0);
    case FaultKind::kCam1:
      return drop_camera(1);
    case FaultKind::kFrames:
      if (stage.random.uniform() >= stage.fault.value) return true;
      ++stage.applied;
      return false;
    case FaultKind::kStamp:
      frame.t -= kStampBack;
      break;
    case FaultKind::kClock:
    case FaultKind::kClockCam:
      frame.t += from_seconds(stage.fault.value);
      break;
    default:
      break_pixels(stage, frame);
      return true;
  }
  ++stage.applied;
  return true;
}

void FaultLine::break_pixels(Stage& stage, StereoFrame& frame) {
  for (int c = 0; c < kCamerasMax; ++c) {
    if ((frame.present >> c & 1) == 0) continue;
    const bool has_held = (stage.held_present >> c & 1) != 0;
    std::vector<uint8_t>& pixels = shown_[frame.id.slot][c];
    switch (stage.fault.kind) {
      case FaultKind::kBlack:
      case FaultKind::kWhite:
        pixels.assign(size_t(frame.image[c].width) * size_t(frame.image[c].height),
                      stage.fault.kind == FaultKind::kBlack ? 0 : 255);
        break;
      case FaultKind::kGain:
        copy(frame.image[c], pixels);
        for (uint8_t& pixel : pixels) {
          pixel = uint8_t(std::min(255.0, std::round(pixel * stage.fault.value)));
        }
        break;
      case FaultKind::kFrozen:
        if (!has_held) continue;
        pixels = stage.held_pixels[c];
        break;
      case FaultKind::kLate:
        if (c == 0 || !has_held) continue;
        pixels = stage.held_pixels[c];
        frame.late[c] = frame.t - stage.held_t;
        break;
      default:
        return;
    }
    frame.image[c].data = pixels.data();
    frame.image[c].stride = frame.image[c].width;
    ++stage.applied;
  }
}

std::vector<Count> FaultLine::applied() const {
  std::vector<Count> out;
  for (const Stage& stage : stages_) out.push_back({stage.fault.spec, stage.applied});
  return out;
}

}  // namespace pirvs::tools
