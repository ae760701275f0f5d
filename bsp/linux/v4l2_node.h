// One camera by V4L2, of its single-planar or its multi-planar interface (rkisp1 has that alone):
// its buffers mapped once, its images lent as they lie there, where they are 8-bit grey. What else
// pixel_format.h knows is made 8-bit grey in memory of our own.
// In      configure(), then take() and fd() from one core; give_back() from any.
// Out     take(): the oldest image. t: the middle of its exposure on CLOCK_MONOTONIC, from what is
//         known best: V4L2_EVENT_FRAME_SYNC of the same sequence (a frame begins to arrive when its
//         exposure has ended), else the buffer's stamp by its source flag, else the arrival.
//         sequence: the sensor's count; a step of more than one: images were lost.
//         lost_before(): by that count, since the image before.
//         exposure_ns: with which it was taken, by the control and the sensor's delay.
//         exposure_of(): of an image by its sequence, also of one to come, as commanded now.
//         control(): exposure and gain from now on, whenever the camera comes back, and again when
//         another program has set them (exposure_changed).
// Units   ns, pixels.
// Errors  take: kEmpty: nothing now. kBusFault: there is no camera: missing, busy, no such format,
//         or unplugged; DeviceNews says which, once, and every kRetry_ns it is looked for again.
//         Images with V4L2_BUF_FLAG_ERROR, too short ones, broken JPEGs, and stale ones (stamped
//         before the stream began) are counted and given back. A camera that is gone while images
//         are lent keeps their memory until the last one is back. One that gave images and
//         then gives nothing for stall_ns, not even a broken one, has its stream stopped and
//         started anew, again and again (stalled).
// Cost    A system call an image, one to read its exposure, another to queue its buffer again at
//         the next take(). No copy of 8-bit grey; of the others that of core/kernels/grey.
// Source  V4L2 API, "Streaming I/O (Memory Mapping)", "Timestamps".
#pragma once

#include <atomic>

#include "bsp/api/camera.h"
#include "bsp/linux/device_news.h"
#include "bsp/linux/media_graph.h"
#include "bsp/linux/pixel_format.h"
#include "bsp/linux/system_calls.h"
#include "bsp/linux/v4l2_controls.h"
#include "core/base/counter.h"

struct v4l2_buffer;  // of <linux/videodev2.h>
struct v4l2_format;

namespace pirvs::bsp {

enum class StampClock : uint8_t { kMonotonic, kBoottime };  // rkisp1 uses the latter, unasked
// What the buffer's stamp is the time of; kDriver: as its flags say.
enum class StampMeans : uint8_t { kDriver, kExposureStart, kFrameEnd };

// kDriver: full, unless the driver says limited.
enum class GreyRange : uint8_t { kDriver, kFull, kLimited };

struct V4l2Setup {
  const char* path = "";
  // Instead of path (which then is its name for people), event_path and controls.sensor: the stages
  // before its video node, set up whenever it is opened.
  MediaRequest media;
  const char* event_path = "";  // of FRAME_SYNC where the video node has none: /dev/v4l-subdevN
  int width = 0, height = 0;
  uint32_t format = 0;  // as V4L2 codes it; 0: the cheapest that the camera has
  GreyRange range = GreyRange::kDriver;
  JpegToGrey jpeg = nullptr;
  StampClock clock = StampClock::kMonotonic;
  StampMeans means = StampMeans::kDriver;
  TimeNs exposure_ns = 0;  // 0: as the camera's control says, if it has one
  TimeNs readout_ns = 0;   // from the end of exposure to the end of the frame
  V4l2ControlSetup controls;
  int control_delay = 2;            // images from a command to the first that it is true of
  TimeNs stall_ns = 2'000'000'000;  // the slowest trigger has 1 Hz
};

struct V4l2Image {
  const uint8_t* data = nullptr;
  int stride = 0;
  TimeNs t = 0;
  TimeNs arrival = 0;
  TimeNs exposure_ns = 0;
  uint32_t sequence = 0;
  int buffer = -1;
};

struct V4l2Counters {
  Counter images, converted, lost, damaged, stale, unstamped, frame_sync_missed, opened, unplugged,
      stalled, exposure_changed, control_refused;
};
inline constexpr CounterRow<V4l2Counters> kV4l2CounterRows[] = {
    {"images", &V4l2Counters::images},
    {"converted", &V4l2Counters::converted},  // made grey in memory of our own
    {"lost", &V4l2Counters::lost},            // by the sequence, before they came to us
    {"damaged", &V4l2Counters::damaged},      // error flag, or too short
    {"stale", &V4l2Counters::stale},          // left from before the stream began
    {"unstamped", &V4l2Counters::unstamped},  // stamped at their arrival, by us
    {"frame_sync_missed", &V4l2Counters::frame_sync_missed},
    {"opened", &V4l2Counters::opened},
    {"unplugged", &V4l2Counters::unplugged},
    {"stalled", &V4l2Counters::stalled},                    // its stream was started anew
    {"exposure_changed", &V4l2Counters::exposure_changed},  // by another program
    {"control_refused", &V4l2Counters::control_refused},
};
static_assert(every_counter_is_in(kV4l2CounterRows));

// Many methods: opening, streaming, stamping and telling of one node, a few lines each.
class V4l2Node {
 public:
  static constexpr TimeNs kRetry_ns = 200'000'000;
  static constexpr int kBuffers = kFramesLentMax + 2  // heads that wait for their partner
                                  + 4;                // for the driver to fill
  static_assert(kBuffers <= 32, "bits of returned_, and VIDEO_MAX_FRAME");

  // The setup's texts must outlive this.
  void configure(const V4l2Setup& setup, const DeviceNews& news,
                 const SystemCalls& calls = kSystemCalls);
  ~V4l2Node();

  Status take(V4l2Image& out);
  void give_back(int buffer) { returned_.fetch_or(1u << buffer, std::memory_order_release); }
  void close();
  void control(const CameraControl& control);
  TimeNs exposure_of(uint32_t sequence) const;
  const V4l2Controls& controls() const { return controls_; }

  bool is_open() const { return fd_ >= 0; }
  bool stalls() const { return stalls_; }  // since its stream was started anew no image came
  // How often its sequence has begun anew.
  uint32_t starts() const { return counters_.opened + counters_.stalled; }
  int fd() const { return fd_; }  // -1: none; it changes whenever the camera comes and goes
  const V4l2Counters& counters() const { return counters_; }

 private:
  struct Buffer {
    uint8_t* data = nullptr;
    size_t size = 0;
    bool lent = false;
  };
  struct FrameSync {
    uint32_t sequence = 0;
    TimeNs t = 0;
  };
  struct ExposedFrom {
    uint32_t sequence = 0;
    TimeNs exposure_ns = 0;
  };
  static constexpr int kSyncs = 8, kExposures = 8;

  Status look_for_camera();
  const char* open_camera();
  const char* set_up_stages();
  const char* find_interface();
  const char* set_format();
  bool take_format(const PixelFormat& wanted, const ::v4l2_format& answer);
  const char* map_grey();
  size_t grey_bytes() const {
    return size_t{kBuffers} * static_cast<size_t>(setup_.width * setup_.height);
  }
  bool lends_as_it_is() const { return format_->is_grey() && !limited_; }
  const uint8_t* grey_of(const ::v4l2_buffer& buffer);
  const char* map_buffers();
  const char* start();
  bool stream();
  Status nothing_came();
  bool queue(int buffer);
  void take_back();
  bool any_lent() const;
  void unmap();
  void gone();
  void read_frame_syncs();
  bool find_frame_sync(uint32_t sequence, TimeNs& t) const;
  void tell_controls();
  void note_exposure(uint32_t sequence);
  void look_at_controls(uint32_t sequence);
  TimeNs mid_exposure(const ::v4l2_buffer& buffer, TimeNs arrival);

  V4l2Setup setup_;
  MediaNodes nodes_;
  Text<160> stage_fault_;
  const SystemCalls* calls_ = &kSystemCalls;
  DeviceTeller teller_;
  V4l2Counters counters_;
  int fd_ = -1, event_fd_ = -1;
  bool frame_sync_ = false;
  V4l2Controls controls_;
  CameraControl control_;
  bool controlled_ = false;
  bool multiplanar_ = false;
  uint32_t type_ = 0;  // of the queue, as V4L2 counts them
  uint32_t planes_ = 1;
  const PixelFormat* format_ = nullptr;
  bool limited_ = false;
  int stride_ = 0;           // of the camera's buffers; 0: JPEG has none
  uint8_t* grey_ = nullptr;  // an image for each buffer, if the camera's are not grey
  TimeNs started_t_ = 0, retry_t_ = 0;
  bool gave_ = false;  // images, since it was opened: before, its trigger may not run yet
  TimeNs came_t_ = 0;  // the newest of them, or the stream's start
  bool stalls_ = false;
  TimeNs exposure_ns_ = 0;
  ExposedFrom exposures_[kExposures];  // a ring, the newest at exposure_at_ - 1
  int exposure_at_ = 0;
  bool has_sequence_ = false;
  uint32_t sequence_ = 0;
  Buffer buffers_[kBuffers];
  int buffer_count_ = 0;
  std::atomic<uint32_t> returned_{0};
  FrameSync syncs_[kSyncs];
  int sync_at_ = 0;
};

}  // namespace pirvs::bsp
