#include "bsp/linux/v4l2_controls.h"

#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>

namespace pirvs::bsp {
namespace {

constexpr double kAbsolute_ns = 100'000;
constexpr double kSecond_ns = 1e9;

}  // namespace

int32_t V4l2Controls::Code::nearest(double value) const {
  const double steps = (value / unit - min) / step;
  const int32_t steps_max = (max - min) / step;
  const double inside = std::clamp(steps, 0.0, static_cast<double>(steps_max));
  return min + static_cast<int32_t>(inside + 0.5) * step;
}

bool V4l2Controls::read(uint32_t id, int32_t& value) {
  v4l2_control control{id, 0};
  if (calls_->ioctl(fd_, VIDIOC_G_CTRL, &control) < 0) return false;
  value = control.value;
  return true;
}

bool V4l2Controls::write(uint32_t id, int32_t value) {
  v4l2_control control{id, value};
  return calls_->ioctl(fd_, VIDIOC_S_CTRL, &control) == 0;
}

// The driver may round: what it says afterwards is what it was told.
bool V4l2Controls::write(Code& code, double value) {
  if (code.unit <= 0) return true;
  const int32_t wanted = code.nearest(value);
  if (!write(code.id, wanted)) return false;
  if (!read(code.id, code.now)) code.now = wanted;
  return true;
}

bool V4l2Controls::find(uint32_t id, double unit, Code& out) {
  constexpr uint32_t kUseless = V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY;
  v4l2_queryctrl query{};
  query.id = id;
  if (unit <= 0 || calls_->ioctl(fd_, VIDIOC_QUERYCTRL, &query) < 0) return false;
  if ((query.flags & kUseless) != 0 || query.maximum <= query.minimum) return false;
  out = {id, unit, query.minimum, query.maximum, std::max(1, query.step), query.minimum};
  (void)read(id, out.now);
  return true;
}

// Of a sensor: 0 if it does not tell its pixel rate.
double V4l2Controls::line_ns(int width) {
  v4l2_ext_control pixel_rate{};
  pixel_rate.id = V4L2_CID_PIXEL_RATE;
  v4l2_ext_controls several{};
  several.which = V4L2_CTRL_WHICH_CUR_VAL;
  several.count = 1;
  several.controls = &pixel_rate;
  int32_t blank = 0;
  const bool told = calls_->ioctl(fd_, VIDIOC_G_EXT_CTRLS, &several) == 0 &&
                    pixel_rate.value64 > 0 && read(V4L2_CID_HBLANK, blank);
  if (!told) return 0;
  v4l2_subdev_format format{};
  format.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  if (calls_->ioctl(fd_, VIDIOC_SUBDEV_G_FMT, &format) == 0 && format.format.width > 0) {
    width = static_cast<int>(format.format.width);
  }
  return (width + blank) * kSecond_ns / static_cast<double>(pixel_rate.value64);
}

// Without a code that is known to mean 1 nobody knows what gain does: it is left alone.
void V4l2Controls::find_gain(int gain_one) {
  for (const uint32_t id : {V4L2_CID_ANALOGUE_GAIN, V4L2_CID_GAIN}) {
    Code code;
    if (!find(id, 1, code)) continue;
    const int one = gain_one > 0 ? gain_one : code.min;
    if (one <= 0) return;
    code.min = std::max(code.min, code.min + (one - code.min) / code.step * code.step);
    code.unit = 1.0 / one;
    gain_ = code;
    return;
  }
}

void V4l2Controls::open(int video_fd, int width, const V4l2ControlSetup& setup,
                        const SystemCalls& calls) {
  close();
  calls_ = &calls;
  own_fd_ = setup.sensor[0] != 0;
  fd_ = own_fd_ ? calls.open(setup.sensor) : video_fd;
  if (fd_ < 0) return;
  const bool found = find(V4L2_CID_EXPOSURE_ABSOLUTE, kAbsolute_ns, exposure_) ||
                     find(V4L2_CID_EXPOSURE, line_ns(width), exposure_);
  if (found) find_gain(setup.gain_one);
}

void V4l2Controls::close() {
  if (own_fd_ && fd_ >= 0) calls_->close(fd_);
  *this = V4l2Controls{};
}

CameraRange V4l2Controls::range() const {
  const auto ns = [this](int32_t code) { return static_cast<TimeNs>(exposure_.value(code)); };
  CameraRange out;
  out.exposure_ns_min = std::max(ns(exposure_.min), ns(exposure_.step));
  out.exposure_ns_max = ns(exposure_.max);
  out.exposure_ns_step = ns(exposure_.step);
  if (gain_.unit > 0) {
    out.gain_min = static_cast<float>(gain_.value(gain_.min));
    out.gain_max = static_cast<float>(gain_.value(gain_.max));
    out.gain_step = static_cast<float>(gain_.value(gain_.step));
  }
  return out;
}

bool V4l2Controls::set(const CameraControl& control) {
  if (!takes_exposure()) return false;
  // Cameras without an automatic of their own refuse these.
  if (control.exposure_ns == 0) {
    (void)write(V4L2_CID_AUTOGAIN, 1);
    return write(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY) ||
           write(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO);
  }
  (void)write(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
  (void)write(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);  // it would lower the frame rate
  (void)write(V4L2_CID_AUTOGAIN, 0);
  const bool exposed = write(exposure_, static_cast<double>(control.exposure_ns));
  return write(gain_, static_cast<double>(control.gain)) && exposed;
}

TimeNs V4l2Controls::exposure_ns() const {
  return static_cast<TimeNs>(exposure_.value(exposure_.now));
}

bool V4l2Controls::look() {
  bool same = true;
  const auto look_at = [&](Code& code) {
    int32_t now = 0;
    if (code.unit <= 0 || !read(code.id, now) || now == code.now) return;
    code.now = now;
    same = false;
  };
  look_at(exposure_);
  if (++looks_ % kGainEvery == 0) look_at(gain_);
  return same;
}

}  // namespace pirvs::bsp
