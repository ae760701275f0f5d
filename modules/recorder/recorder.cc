#include "modules/recorder/recorder.h"

#include <iterator>

#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/api/events.h"
#include "core/base/assert.h"
#include "modules/recorder/sensor_yaml.h"

namespace pirvs {
namespace {

constexpr const char* kCameraTable[] = {"mav0/cam0/data.csv", "mav0/cam1/data.csv"};
constexpr const char* kCameraYaml[] = {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"};
constexpr const char* kCameraImages[] = {"mav0/cam0/data/", "mav0/cam1/data/"};
static_assert(std::size(kCameraTable) == kCamerasMax);

constexpr int kDoorCore = 0;  // in every plan; a replay waits there until there is room

}  // namespace

const char* name(RecordLoss loss) {
  static constexpr const char* kNames[] = {"record_imu_dropped", "record_frame_dropped",
                                           "record_order_dropped", "record_map_dropped",
                                           "record_not_written"};
  static_assert(std::size(kNames) == static_cast<size_t>(RecordLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

Result<bsp::File> Recorder::open_file(const char* name) const {
  Text<192> path;
  path.put(folder_).put(name);
  PIRVS_ASSERT(!path.full());
  return bsp::storage_open(path.c_str());
}

Status Recorder::open(Table& table, const char* name, const char* heading) {
  const Result<bsp::File> file = open_file(name);
  if (!file.ok()) return file.status();
  table.file = file.value();
  table.open = true;
  table.block.clear();
  table.block.put(heading);
  return Status::kOk;
}

Status Recorder::start(const Calibration& calibration, const char* folder) {
  if (busy()) return Status::kStale;
  folder_ = folder;
  failed_ = false;
  flush_t_ = 0;
  repeated_names_ = 0;
  for (TimeNs& t : last_t_) t = INT64_MIN;
  while (map_ring_.front() != nullptr) map_ring_.pop();  // it came while the last one ended
  for (int c = 0; c < calibration.cameras; ++c) {
    PIRVS_TRY(write_camera_yaml(c, calibration.camera[c], calibration.camera_time_offset_ns));
    PIRVS_TRY(open(camera_[c], kCameraTable[c], "#timestamp [ns],filename\n"));
  }
  PIRVS_TRY(write_imu_yaml(calibration));
  const GnssAntenna& antenna = calibration.gnss;
  const bool gnss = !antenna.p_BA.isZero(0) || antenna.time_offset_ns != 0;
  if (gnss) PIRVS_TRY(write_gnss_yaml(antenna));
  PIRVS_TRY(open(imu_, "mav0/imu0/data.csv",
                 "#timestamp [ns],w_x [rad/s],w_y [rad/s],w_z [rad/s],f_x [m/s^2],f_y [m/s^2],"
                 "f_z [m/s^2]\n"));
  PIRVS_TRY(open(order_, "mav0/order.csv", kOrderHeading));
  PIRVS_TRY(open(maps_, "mav0/maps.csv", "#frame [ns],keyframe\n"));
  started_ = true;
  state_.store(State::kRecording, std::memory_order_release);
  if (core_ >= 0) bsp::wake(core_);
  return Status::kOk;
}

Status Recorder::write_text(const char* name, const TextWriter& text) {
  PIRVS_ASSERT(!text.full());
  const Result<bsp::File> file = open_file(name);
  if (!file.ok()) return file.status();
  const Status written = bsp::storage_write(file.value(), text.c_str(), text.size());
  const Status closed = bsp::storage_close(file.value());
  return written != Status::kOk ? written : closed;
}

Status Recorder::write_camera_yaml(int c, const Camera& camera, TimeNs offset) {
  Text<kBlock> text;
  put_camera_yaml(text, camera, offset);
  return write_text(kCameraYaml[c], text);
}

Status Recorder::write_imu_yaml(const Calibration& calibration) {
  Text<kBlock> text;
  put_imu_yaml(text, calibration.imu, calibration.imu_intrinsics);
  return write_text("mav0/imu0/sensor.yaml", text);
}

Status Recorder::write_gnss_yaml(const GnssAntenna& antenna) {
  Text<kBlock> text;
  text.put("sensor_type: gnss\nT_BS:\n  cols: 4\n  rows: 4\n  data: [");
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) text.put(i == j ? "1, " : "0, ");
    text.exact(antenna.p_BA[i]).put(", ");
  }
  text.put("0, 0, 0, 1]\ntime_offset: ").exact(to_seconds(antenna.time_offset_ns)).put("\n");
  return write_text("mav0/gnss0/sensor.yaml", text);
}

// A row that cannot be kept leaves its item out, too: the rows that follow must find theirs.
void Recorder::arrival(const Arrival& arrival) {
  OrderRow* const row = order_ring_.begin_push();
  if (row == nullptr) return losses_.add(RecordLoss::kOrderDropped);
  *row = order_row_of(arrival);
  if (arrival.kind == ArrivalKind::kImu && !imu(arrival.imu)) return;
  if (arrival.kind == ArrivalKind::kFrame && !frame(arrival.frame)) return;
  order_ring_.end_push();
}

void Recorder::decision(TimeNs t, uint32_t keyframe) {
  if (!map_ring_.push({t, keyframe})) losses_.add(RecordLoss::kMapDropped);
}

bool Recorder::imu(const ImuSample& sample) {
  const bool kept = imu_ring_.push(sample);
  if (!kept) losses_.add(RecordLoss::kImuDropped);
  return kept;
}

bool Recorder::frame(const StereoFrame& frame) {
  StereoFrame* const held = frame_ring_.begin_push();
  if (held == nullptr) {
    losses_.add(RecordLoss::kFrameDropped);
    return false;
  }
  bsp::camera_retain(frame.id);
  *held = frame;
  frame_ring_.end_push();
  if (core_ >= 0) bsp::wake(core_);
  return true;
}

bool Recorder::has_room() const {
  return imu_ring_.size() + kImuRoom <= kImuRing && frame_ring_.size() < kFramesHeld &&
         order_ring_.size() + 2 * kImuRoom <= kOrderRing && map_ring_.size() < kMapRing;
}

// The first error is the last thing that is tried.
void Recorder::check(Status status) {
  if (status == Status::kOk) return;
  losses_.add(RecordLoss::kNotWritten);
  if (failed_) return;
  failed_ = true;
  bsp::console_write(status == Status::kFull
                         ? "recording stopped: the disk is full; the run goes on\n"
                         : "recording stopped: it cannot be written; the run goes on\n");
}

Status Recorder::Table::write_when_full() {
  PIRVS_ASSERT(!block.full());
  return block.room() >= kOrderRowMax ? Status::kOk : write();
}

Status Recorder::Table::write() {
  if (block.size() == 0) return Status::kOk;
  const Status status = bsp::storage_write(file, block.c_str(), block.size());
  block.clear();
  return status;
}

void Recorder::flush_when_due() {
  const TimeNs t = bsp::now();
  if (t < flush_t_ || failed_) return;
  flush_t_ = t + kFlush_ns;
  for (Table* table : {&imu_, &order_, &maps_, &camera_[0], &camera_[1]}) {
    if (table->open) check(table->write());
  }
}

Status Recorder::write_sample(const ImuSample& sample) {
  if (failed_) return Status::kFull;
  imu_.block.number(sample.t);
  for (int i = 0; i < 3; ++i) imu_.block.put(",").exact(sample.w_B[i]);
  for (int i = 0; i < 3; ++i) imu_.block.put(",").exact(sample.f_B[i]);
  imu_.block.put("\n");
  return imu_.write_when_full();
}

Status Recorder::write_order(const OrderRow& row) {
  if (failed_) return Status::kFull;
  put(order_.block, row);
  return order_.write_when_full();
}

Status Recorder::write_map(const MapRow& row) {
  if (failed_) return Status::kFull;
  maps_.block.number(row.t).put(',').number(row.keyframe).put('\n');
  return maps_.write_when_full();
}

Status Recorder::write_image(const ImageView& image, const char* name) {
  const Result<bsp::File> file = open_file(name);
  if (!file.ok()) return file.status();
  Text<64> head;
  head.put("P5\n").number(image.width).put(" ").number(image.height);
  head.put("\n255\n");
  Status status = bsp::storage_write(file.value(), head.c_str(), head.size());
  // Rows without gaps are one block.
  const bool whole = image.stride == image.width;
  const int blocks = whole ? 1 : image.height;
  const auto size =
      static_cast<size_t>(image.width) * static_cast<size_t>(whole ? image.height : 1);
  for (int y = 0; y < blocks && status == Status::kOk; ++y) {
    status = bsp::storage_write(file.value(), image.row(y), size);
  }
  const Status closed = bsp::storage_close(file.value());
  return status != Status::kOk ? status : closed;
}

Status Recorder::write_camera(const StereoFrame& frame, int c) {
  if (failed_) return Status::kFull;
  const TimeNs t = frame.t - frame.late[c];
  Text<64> file;
  file.number(t);
  if (t <= last_t_[c]) file.put("_").number(++repeated_names_);  // never over an older one
  last_t_[c] = t > last_t_[c] ? t : last_t_[c];
  file.put(".pgm");
  Text<128> path;
  path.put(kCameraImages[c]).put(file.c_str());
  PIRVS_TRY(write_image(frame.image[c], path.c_str()));
  camera_[c].block.number(t).put(",").put(file.c_str()).put("\n");
  return camera_[c].write_when_full();
}

Step Recorder::step() {
  bool worked = false;
  for (ImuSample* sample = imu_ring_.front(); sample != nullptr; sample = imu_ring_.front()) {
    check(write_sample(*sample));
    imu_ring_.pop();
    worked = true;
  }
  for (OrderRow* row = order_ring_.front(); row != nullptr; row = order_ring_.front()) {
    check(write_order(*row));
    order_ring_.pop();
    worked = true;
  }
  for (MapRow* row = map_ring_.front(); row != nullptr; row = map_ring_.front()) {
    check(write_map(*row));
    map_ring_.pop();
    worked = true;
  }
  if (worked) flush_when_due();
  const StereoFrame* const frame = frame_ring_.front();
  if (frame == nullptr) return worked ? Step::kAgain : Step::kIdle;
  for (int c = 0; c < kCamerasMax; ++c) {
    if ((frame->present >> c & 1) != 0) check(write_camera(*frame, c));
  }
  bsp::camera_release(frame->id);
  frame_ring_.pop();
  if (core_ >= 0) bsp::wake(kDoorCore);
  if (!failed_) ++frames_written_;
  return Step::kAgain;
}

void Recorder::stop() {
  State was = State::kRecording;
  state_.compare_exchange_strong(was, State::kStopping);
  if (core_ >= 0) bsp::wake(core_);
}

void Recorder::end() {
  stop();
  ending_.store(true, std::memory_order_release);
  if (core_ >= 0) bsp::wake(core_);
}

void Recorder::run() {
  constexpr TimeNs kRest_ns = 50'000'000;  // samples do not wake: their ring is long
  constexpr TimeNs kIdle_ns = 10'000'000'000;
  for (;;) {
    const bool ending = ending_.load(std::memory_order_acquire);
    const State state = state_.load(std::memory_order_acquire);
    if (state == State::kIdle) {
      if (ending) return;
      bsp::wait(core_, bsp::now() + kIdle_ns);
    } else if (step() == Step::kIdle) {
      if (state == State::kStopping) {
        finish();
      } else {
        bsp::wait(core_, bsp::now() + kRest_ns);
      }
    }
  }
}

void Recorder::finish() {
  for (Table* table : {&imu_, &order_, &maps_, &camera_[0], &camera_[1]}) {
    if (!table->open) continue;
    if (!failed_) check(bsp::storage_write(table->file, table->block.c_str(), table->block.size()));
    const Status closed = bsp::storage_close(table->file);
    if (!failed_) check(closed);
    table->open = false;
  }
  state_.store(State::kIdle, std::memory_order_release);
}

}  // namespace pirvs
