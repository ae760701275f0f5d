// Writes everything that comes to the sensor door as an ASL folder, beside the estimator and never
// in its way: raw, before any of it is judged, so that a run can be had again.
// In      arrival(): from the door's core, in the order of arrival; decision(): what a frame in
//         work goes by that arrivals do not say. step(): from a core that has time, at best its
//         own. A frame is held (bsp::camera_retain) until it is written. One recording may follow
//         the other, each in a folder of its own.
// Out     By bsp/api/storage.h, below the recording's folder: mav0/cam*/data/*.pgm with data.csv
//         and sensor.yaml, imu0 likewise, gnss0/sensor.yaml if there is an antenna. An image is
//         listed once it is complete, and rows wait for kFlush_ns at most, so that what is left
//         after a power cut is whole. Numbers read back to the bit. mav0/order.csv: a row for each
//         arrival in its order, so that a replay can follow it (order_row.h). mav0/maps.csv: the
//         newest keyframe that mapping had finished when each frame began.
// Units   ns, rad/s, m/s^2, grey values, as the sensors have them.
// Errors  Rings full: the item is dropped and counted. Storage full or broken: said once on the
//         console; what comes after is dropped and counted; nobody else is told or delayed.
// Cost    frame(): no copy of pixels. step(): one file.
// Source  ASL data set format (Burri et al., IJRR 2016); netpbm, "PGM".
#pragma once

#include <atomic>

#include "bsp/api/camera.h"
#include "bsp/api/imu.h"
#include "bsp/api/storage.h"
#include "core/base/counter.h"
#include "core/base/text.h"
#include "core/camera/camera.h"
#include "core/sched/scheduler.h"
#include "core/store/ring.h"
#include "modules/calibration/calibration.h"
#include "modules/door/arrival.h"
#include "modules/imu/imu_noise.h"
#include "modules/recorder/order_row.h"

namespace pirvs {

enum class RecordLoss : uint8_t {
  kImuDropped,
  kFrameDropped,
  kOrderDropped,
  kMapDropped,
  kNotWritten,
  kCount
};
const char* name(RecordLoss loss);

// Many methods: its life, what comes and one for each file that is written, a line or a few each.
class Recorder {
 public:
  static constexpr size_t kFramesHeld = 6;  // 0.3 s at 20 Hz: a disk's usual stall
  static constexpr TimeNs kFlush_ns = 500'000'000;

  // Opens the files and writes the calibration. `folder` ends with '/' unless it is empty; the text
  // must stay while busy(). kStale: the last recording has not been written to its end.
  Status start(const Calibration& calibration, const char* folder = "");
  bool started() const { return started_; }  // this recording or an earlier one
  bool recording() const { return state_ == State::kRecording; }
  bool busy() const { return state_ != State::kIdle; }

  void arrival(const Arrival& arrival);
  // When tracking began the frame of time t, mapping had finished this keyframe and all before it.
  void decision(TimeNs t, uint32_t keyframe);
  // Room for what the door may ask of the sensors in one step; a replay can wait for it.
  bool has_room() const;

  Step step();
  void finish();  // after the last step: writes out what waits and closes; no longer busy()
  // The writer's core, before run() begins there: it is woken when there is a frame to write.
  void set_core(int core) { core_ = core; }
  // No more will come of this recording: run() finishes it once the rings are empty.
  void stop();
  // Likewise, and then run() returns.
  void end();
  void run();

  const CounterArray<RecordLoss>& losses() const { return losses_; }
  uint32_t frames_written() const { return frames_written_; }

 private:
  static constexpr size_t kBlock = 4096;
  // A table of text that grows block by block.
  struct Table {
    bsp::File file;
    bool open = false;
    Text<kBlock> block;

    Status write_when_full();
    Status write();
  };

  // Idle, the door's core may start; else all but the rings' writing ends is the writer's.
  enum class State : uint8_t { kIdle, kRecording, kStopping };

  struct MapRow {
    TimeNs t;
    uint32_t keyframe;
  };

  static constexpr size_t kImuRing = 1024;                     // 5 s at 200 Hz
  static constexpr size_t kImuRoom = 256;                      // a step of the door takes fewer
  static constexpr size_t kOrderRing = kImuRing + kFramesHeld  // all that waits beside it
                                       + 512                   // ticks of 5 s
                                       + 512;                  // all else
  static constexpr size_t kMapRing = 512;                      // 5 s at 100 frames a second

  Result<bsp::File> open_file(const char* name) const;
  Status open(Table& table, const char* name, const char* heading);
  Status write_camera_yaml(int c, const Camera& camera, TimeNs offset);
  Status write_imu_yaml(const Calibration& calibration);
  Status write_gnss_yaml(const GnssAntenna& antenna);
  Status write_text(const char* name, const TextWriter& text);
  Status write_image(const ImageView& image, const char* name);
  void flush_when_due();
  Status write_sample(const ImuSample& sample);
  Status write_camera(const StereoFrame& frame, int c);
  Status write_order(const OrderRow& row);
  Status write_map(const MapRow& row);
  bool imu(const ImuSample& sample);
  bool frame(const StereoFrame& frame);
  void check(Status status);

  Ring<ImuSample, kImuRing> imu_ring_;
  Ring<StereoFrame, kFramesHeld> frame_ring_;
  Ring<OrderRow, kOrderRing> order_ring_;
  Ring<MapRow, kMapRing> map_ring_;
  Table imu_, order_, maps_, camera_[kCamerasMax];
  TimeNs last_t_[kCamerasMax] = {INT64_MIN, INT64_MIN};
  TimeNs flush_t_ = 0;         // of the next one
  std::atomic<int> core_{-1};  // none: steps are called by hand
  const char* folder_ = "";
  std::atomic<bool> started_{false};  // by a command, while App::counters() may ask
  std::atomic<State> state_{State::kIdle};
  std::atomic<bool> ending_{false};
  bool failed_ = false;
  Counter frames_written_;
  uint32_t repeated_names_ = 0;
  CounterArray<RecordLoss> losses_;
};

}  // namespace pirvs
