#include "bsp/linux/v4l2_node.h"

#include <errno.h>
#include <linux/videodev2.h>
#include <time.h>

#include <algorithm>

#include "bsp/api/clock.h"

namespace pirvs::bsp {

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

TimeNs ns_of(const timeval& t) { return t.tv_sec * kSecond_ns + t.tv_usec * TimeNs{1000}; }

// The machine's sleep counts on one clock and not on the other.
TimeNs boottime_ahead() {
  timespec t;
  clock_gettime(CLOCK_BOOTTIME, &t);
  return t.tv_sec * kSecond_ns + t.tv_nsec - now();
}

// As both interfaces have it: the multi-planar one says of its planes elsewhere.
struct PlanarBuffer : v4l2_buffer {
  v4l2_plane planes[VIDEO_MAX_PLANES] = {};

  PlanarBuffer(uint32_t of_type, uint32_t plane_count) : v4l2_buffer{} {
    type = of_type;
    memory = V4L2_MEMORY_MMAP;
    if (of_type != V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) return;
    m.planes = planes;
    length = plane_count;
  }
  v4l2_buffer* get() { return this; }
};

const char* why_not_open() {
  switch (errno) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "no such camera, waiting for it";
    case EBUSY:
      return "another program has the camera, waiting for it";
    case EACCES:
    case EPERM:
      return "no permission to use the camera";
    default:
      return "the camera cannot be opened, trying again";
  }
}

}  // namespace

void V4l2Node::configure(const V4l2Setup& setup, const DeviceNews& news, const SystemCalls& calls) {
  PIRVS_ASSERT(!is_open());
  setup_ = setup;
  calls_ = &calls;
  teller_.configure(news);
}

// ---- coming and going --------------------------------------------------------------------------

Status V4l2Node::look_for_camera() {
  if (any_lent() || now() < retry_t_) return Status::kBusFault;
  unmap();
  retry_t_ = now() + kRetry_ns;
  const char* const why = open_camera();
  if (why != nullptr) {
    close();
    teller_.tell(setup_.path, why);
    return Status::kBusFault;
  }
  ++counters_.opened;
  teller_.tell(setup_.path, "camera started");
  return Status::kOk;
}

const char* V4l2Node::set_up_stages() {
  setup_.media.width = setup_.width;
  setup_.media.height = setup_.height;
  if (!set_up_media(setup_.media, *calls_, nodes_, stage_fault_)) return stage_fault_.c_str();
  setup_.event_path = nodes_.events;
  setup_.controls.sensor = nodes_.sensor;
  return nullptr;
}

const char* V4l2Node::open_camera() {
  const bool by_table = setup_.media.table != nullptr;
  if (const char* const why = by_table ? set_up_stages() : nullptr) return why;
  fd_ = calls_->open(by_table ? nodes_.video : setup_.path);
  if (fd_ < 0) return why_not_open();
  if (const char* const why = find_interface()) return why;
  if (const char* const why = set_format()) return why;
  if (const char* const why = map_buffers()) return why;
  return start();
}

const char* V4l2Node::find_interface() {
  v4l2_capability about{};
  if (calls_->ioctl(fd_, VIDIOC_QUERYCAP, &about) < 0) return "not a camera of V4L2";
  const uint32_t can =
      (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  multiplanar_ = (can & V4L2_CAP_VIDEO_CAPTURE) == 0;
  type_ = multiplanar_ ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  const bool captures = (can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0;
  if (!captures || (can & V4L2_CAP_STREAMING) == 0) return "not a camera that streams by V4L2";
  return nullptr;
}

// False: the camera answered with something else.
bool V4l2Node::take_format(const PixelFormat& wanted, const v4l2_format& answer) {
  const v4l2_pix_format& pix = answer.fmt.pix;
  const v4l2_pix_format_mplane& mp = answer.fmt.pix_mp;
  // Both begin with width, height and pixelformat.
  const bool as_asked = pix.width == static_cast<uint32_t>(setup_.width) &&
                        pix.height == static_cast<uint32_t>(setup_.height) &&
                        pix.pixelformat == wanted.code;
  if (!as_asked) return false;
  planes_ = multiplanar_ ? mp.num_planes : 1;
  if (planes_ < 1 || planes_ > VIDEO_MAX_PLANES) return false;
  const uint32_t stride = multiplanar_ ? mp.plane_fmt[0].bytesperline : pix.bytesperline;
  const uint32_t range = multiplanar_ ? mp.quantization : pix.quantization;
  format_ = &wanted;
  stride_ =
      wanted.is_jpeg() ? 0 : std::max(static_cast<int>(stride), wanted.row_bytes(setup_.width));
  limited_ = setup_.range == GreyRange::kDriver ? range == V4L2_QUANTIZATION_LIM_RANGE
                                                : setup_.range == GreyRange::kLimited;
  return true;
}

const char* V4l2Node::set_format() {
  for (const PixelFormat& wanted : pixel_formats()) {
    if (setup_.format != 0 && wanted.code != setup_.format) continue;
    if (wanted.is_jpeg() && setup_.jpeg == nullptr) continue;
    v4l2_format format{};
    format.type = type_;
    v4l2_pix_format& pix = format.fmt.pix;  // as pix_mp, to its field
    pix.width = static_cast<uint32_t>(setup_.width);
    pix.height = static_cast<uint32_t>(setup_.height);
    pix.pixelformat = wanted.code;
    pix.field = V4L2_FIELD_NONE;
    // A camera answers with what it can do instead, or refuses.
    if (calls_->ioctl(fd_, VIDIOC_S_FMT, &format) < 0) {
      if (errno == EINVAL) continue;
      return why_not_open();
    }
    if (!take_format(wanted, format)) continue;
    return lends_as_it_is() ? nullptr : map_grey();
  }
  return "the camera cannot give the calibration's size in a format that can be made grey";
}

// Once: a camera that comes back uses it again.
const char* V4l2Node::map_grey() {
  if (grey_ != nullptr) return nullptr;
  grey_ = static_cast<uint8_t*>(calls_->map(grey_bytes(), -1, 0));
  return grey_ != nullptr ? nullptr : "no memory for grey images";
}

const char* V4l2Node::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
  if (calls_->ioctl(fd_, VIDIOC_REQBUFS, &request) < 0) return why_not_open();
  if (request.count < static_cast<uint32_t>(kFramesLentMax)) return "the camera has no memory";
  buffer_count_ = std::min(static_cast<int>(request.count), kBuffers);
  const auto needed = static_cast<size_t>(stride_) * static_cast<size_t>(setup_.height);
  for (int i = 0; i < buffer_count_; ++i) {
    PlanarBuffer buffer(type_, planes_);
    buffer.index = static_cast<uint32_t>(i);
    if (calls_->ioctl(fd_, VIDIOC_QUERYBUF, buffer.get()) < 0) return "the camera has no memory";
    // The first plane is the luma: nobody looks at the others.
    const size_t length = multiplanar_ ? buffer.planes[0].length : buffer.length;
    const uint32_t offset = multiplanar_ ? buffer.planes[0].m.mem_offset : buffer.m.offset;
    void* const at = calls_->map(length, fd_, offset);
    if (at == nullptr || length < needed) return "the camera's memory cannot be mapped";
    buffers_[i] = {static_cast<uint8_t*>(at), length, false};
  }
  return nullptr;
}

const char* V4l2Node::start() {
  controls_.open(fd_, setup_.width, setup_.controls, *calls_);
  event_fd_ = setup_.event_path[0] != 0 ? calls_->open(setup_.event_path) : fd_;
  v4l2_event_subscription events{};
  events.type = V4L2_EVENT_FRAME_SYNC;
  frame_sync_ = event_fd_ >= 0 && calls_->ioctl(event_fd_, VIDIOC_SUBSCRIBE_EVENT, &events) == 0;
  gave_ = stalls_ = false;
  if (stream()) return nullptr;
  if (errno == EINVAL) return "the camera refuses its buffers";
  return errno == EPIPE ? "the camera's stages do not fit together" : why_not_open();
}

// Gives the driver all buffers that are not lent, and starts. False: errno says why not.
bool V4l2Node::stream() {
  has_sequence_ = false;
  exposure_at_ = 0;
  for (ExposedFrom& exposure : exposures_) exposure = {0, controls_.exposure_ns()};
  if (controlled_) tell_controls();
  for (int i = 0; i < buffer_count_; ++i) {
    if (!buffers_[i].lent && !queue(i)) return false;
  }
  came_t_ = started_t_ = now();
  auto type = static_cast<int>(type_);
  return calls_->ioctl(fd_, VIDIOC_STREAMON, &type) == 0;
}

V4l2Node::~V4l2Node() {
  close();
  if (grey_ != nullptr) calls_->unmap(grey_, grey_bytes());
}

void V4l2Node::close() {
  controls_.close();
  if (event_fd_ >= 0 && event_fd_ != fd_) calls_->close(event_fd_);
  if (fd_ >= 0) calls_->close(fd_);
  fd_ = event_fd_ = -1;
  take_back();
  if (!any_lent()) unmap();
}

// Its mappings outlive the node: who reads an image may go on.
void V4l2Node::gone() {
  ++counters_.unplugged;
  close();
  retry_t_ = now() + kRetry_ns;
  teller_.tell(setup_.path, "camera unplugged, waiting for it");
}

// Cameras of USB and ISPs may stall and stay: their node is there, and says nothing.
Status V4l2Node::nothing_came() {
  if (!gave_ || now() < came_t_ + setup_.stall_ns) return Status::kEmpty;
  ++counters_.stalled;
  stalls_ = true;
  teller_.tell(setup_.path, "camera stalled, its stream is started anew");
  auto type = static_cast<int>(type_);
  if (calls_->ioctl(fd_, VIDIOC_STREAMOFF, &type) == 0 && stream()) return Status::kEmpty;
  gone();
  return Status::kBusFault;
}

// ---- buffers -----------------------------------------------------------------------------------

bool V4l2Node::any_lent() const {
  const auto lent = [](const Buffer& buffer) { return buffer.lent; };
  return std::any_of(buffers_, buffers_ + buffer_count_, lent);
}

void V4l2Node::unmap() {
  for (Buffer& buffer : buffers_) {
    if (buffer.data != nullptr) calls_->unmap(buffer.data, buffer.size);
    buffer = Buffer{};
  }
  buffer_count_ = 0;
}

bool V4l2Node::queue(int index) {
  PlanarBuffer buffer(type_, planes_);
  buffer.index = static_cast<uint32_t>(index);
  return calls_->ioctl(fd_, VIDIOC_QBUF, buffer.get()) == 0;
}

// Acquire: whoever gave it back has read what he wanted.
void V4l2Node::take_back() {
  const uint32_t returned = returned_.exchange(0, std::memory_order_acquire);
  for (int i = 0; i < buffer_count_; ++i) {
    if ((returned >> i & 1u) == 0) continue;
    PIRVS_ASSERT(buffers_[i].lent);
    buffers_[i].lent = false;
    if (is_open()) (void)queue(i);  // an unplugged camera says so at the next image
  }
}

// ---- time --------------------------------------------------------------------------------------

void V4l2Node::read_frame_syncs() {
  if (!frame_sync_) return;
  v4l2_event event{};
  while (calls_->ioctl(event_fd_, VIDIOC_DQEVENT, &event) == 0) {
    if (event.type != V4L2_EVENT_FRAME_SYNC) continue;
    syncs_[sync_at_] = {event.u.frame_sync.frame_sequence,
                        event.timestamp.tv_sec * kSecond_ns + event.timestamp.tv_nsec};
    sync_at_ = (sync_at_ + 1) % kSyncs;
  }
}

bool V4l2Node::find_frame_sync(uint32_t sequence, TimeNs& t) const {
  for (const FrameSync& sync : syncs_) {
    if (sync.t < started_t_ || sync.sequence != sequence) continue;
    t = sync.t;
    return true;
  }
  return false;
}

// Images from this one on are exposed as the control says now.
void V4l2Node::note_exposure(uint32_t sequence) {
  exposures_[exposure_at_] = {sequence, controls_.exposure_ns()};
  exposure_at_ = (exposure_at_ + 1) % kExposures;
}

void V4l2Node::tell_controls() {
  if (!controls_.takes_exposure()) return;
  if (!controls_.set(control_)) ++counters_.control_refused;
  const bool running = has_sequence_;
  note_exposure(running ? sequence_ + static_cast<uint32_t>(setup_.control_delay) : 0);
}

void V4l2Node::control(const CameraControl& control) {
  control_ = control;
  controlled_ = true;
  if (is_open()) tell_controls();
}

// When an image is taken. What another program sets is true as soon as it is seen.
void V4l2Node::look_at_controls(uint32_t sequence) {
  if (setup_.exposure_ns != 0 || !controls_.takes_exposure() || controls_.look()) return;
  note_exposure(sequence);
  const bool ours = controlled_ && control_.exposure_ns != 0;
  if (!ours) return;
  ++counters_.exposure_changed;
  tell_controls();
}

TimeNs V4l2Node::exposure_of(uint32_t sequence) const {
  if (setup_.exposure_ns != 0) return setup_.exposure_ns;
  if (!controls_.takes_exposure()) return 0;
  for (int i = 1; i <= kExposures; ++i) {
    const ExposedFrom& from = exposures_[(exposure_at_ + kExposures - i) % kExposures];
    if (static_cast<int32_t>(sequence - from.sequence) >= 0) return from.exposure_ns;
  }
  return controls_.exposure_ns();
}

TimeNs V4l2Node::mid_exposure(const v4l2_buffer& buffer, TimeNs arrival) {
  const TimeNs half = exposure_ns_ / 2;
  TimeNs t = 0;
  if (frame_sync_) {
    if (find_frame_sync(buffer.sequence, t)) return t - half;
    ++counters_.frame_sync_missed;
  }
  const uint32_t kind = buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK;
  const bool stamped = kind != V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  if (!stamped && setup_.means == StampMeans::kDriver) {
    ++counters_.unstamped;
    return arrival - setup_.readout_ns - half;
  }
  t = ns_of(buffer.timestamp);
  if (setup_.clock == StampClock::kBoottime) t -= boottime_ahead();
  const bool at_start =
      setup_.means == StampMeans::kExposureStart ||
      (setup_.means == StampMeans::kDriver &&
       (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE);
  return at_start ? t + half : t - setup_.readout_ns - half;
}

// ---- images ------------------------------------------------------------------------------------

// The image of a buffer, which is made grey if it is not. nullptr: it is broken.
const uint8_t* V4l2Node::grey_of(const v4l2_buffer& buffer) {
  const uint8_t* const data = buffers_[buffer.index].data;
  if (lends_as_it_is()) return data;
  ++counters_.converted;
  const RawBuffer raw = {data, buffer.bytesused, stride_, setup_.width, setup_.height, limited_};
  uint8_t* const out = grey_ + grey_bytes() / kBuffers * size_t{buffer.index};
  return make_grey(*format_, raw, setup_.jpeg, out) ? out : nullptr;
}

Status V4l2Node::take(V4l2Image& out) {
  take_back();
  if (!is_open() && look_for_camera() != Status::kOk) return Status::kBusFault;
  for (;;) {
    PlanarBuffer buffer(type_, planes_);
    if (calls_->ioctl(fd_, VIDIOC_DQBUF, buffer.get()) < 0) {
      if (errno == EAGAIN) return nothing_came();
      gone();
      return Status::kBusFault;
    }
    if (multiplanar_) buffer.bytesused = buffer.planes[0].bytesused;
    const auto index = static_cast<int>(buffer.index);
    PIRVS_ASSERT(index < buffer_count_ && !buffers_[index].lent);
    const TimeNs arrival = now();
    came_t_ = arrival;
    if (stalls_) teller_.tell(setup_.path, "camera gives images again");
    stalls_ = false;
    read_frame_syncs();
    // Between two images less than half of all numbers are lost.
    const uint32_t step = buffer.sequence - sequence_;
    if (has_sequence_ && step - 1 < UINT32_MAX / 2) counters_.lost += step - 1;
    sequence_ = buffer.sequence;
    has_sequence_ = true;
    look_at_controls(buffer.sequence);
    exposure_ns_ = exposure_of(buffer.sequence);
    const TimeNs t = mid_exposure(buffer, arrival);
    const auto needed = static_cast<uint32_t>(stride_ * setup_.height);
    bool damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || buffer.bytesused < needed;
    constexpr TimeNs kCut_ns = 1'000;  // stamps are whole microseconds, cut off
    const bool stale = !damaged && t + kCut_ns <= started_t_;
    const uint8_t* const grey = damaged || stale ? nullptr : grey_of(buffer);
    damaged |= grey == nullptr && !stale;
    if (damaged) ++counters_.damaged;
    if (stale) ++counters_.stale;
    if (grey == nullptr) {
      (void)queue(index);
      continue;
    }
    buffers_[index].lent = true;
    gave_ = true;
    ++counters_.images;
    const int stride = lends_as_it_is() ? stride_ : setup_.width;
    out = {grey, stride, t, arrival, exposure_ns_, buffer.sequence, index};
    return Status::kOk;
  }
}

}  // namespace pirvs::bsp
