#include "modules/map/map_file.h"

#include <cmath>
#include <cstring>
#include <new>

#include "core/base/crc32.h"
#include "modules/map/nodes.h"

namespace pirvs {
namespace {

constexpr char kMagic[8] = {'P', 'I', 'R', 'V', 'S', 'M', 'A', 'P'};
constexpr uint32_t kVersion = 2;  // 1 had no nodes, where 2 counts them it had 0
constexpr size_t kBlock = 4096;

struct MapFileHeader {
  char magic[8];
  uint32_t version;
  uint32_t points, keyframes, nodes;
  uint64_t payload_bytes;  // between this header and the checksum
};

// The position of each live point among those saved.
constexpr uint32_t kNoPoint = UINT32_MAX;

// Either counts bytes, or writes them in blocks and sums them up.
class Writer {
 public:
  explicit Writer(const MapSink* sink) : sink_(sink) {}

  void bytes(const void* data, size_t size) {
    count_ += size;
    if (sink_ == nullptr) return;
    crc_.add(data, size);
    const uint8_t* from = static_cast<const uint8_t*>(data);
    while (size > 0) {
      const size_t part = size < kBlock - used_ ? size : kBlock - used_;
      std::memcpy(block_ + used_, from, part);
      used_ += part;
      from += part;
      size -= part;
      if (used_ == kBlock) flush();
    }
  }
  template <class T>
  void put(const T& value) {
    bytes(&value, sizeof value);
  }
  void flush() {
    if (status_ == Status::kOk && used_ > 0) status_ = sink_->write(sink_->context, block_, used_);
    used_ = 0;
  }
  uint64_t count() const { return count_; }
  uint32_t crc() const { return crc_.value(); }
  Status status() const { return status_; }

 private:
  const MapSink* sink_;
  Crc32 crc_;
  uint64_t count_ = 0;
  size_t used_ = 0;
  Status status_ = Status::kOk;
  uint8_t block_[kBlock];
};

class Reader {
 public:
  explicit Reader(const MapSource& source) : source_(source) {}
  void bytes(void* data, size_t size) {
    if (status_ == Status::kOk) status_ = source_.read(source_.context, data, size);
    if (status_ != Status::kOk) std::memset(data, 0, size);
    crc_.add(data, size);
  }
  template <class T>
  T get() {
    T value;
    bytes(&value, sizeof value);
    return value;
  }
  template <class Matrix>
  Matrix matrix() {
    Matrix out;
    bytes(out.data(), sizeof(double) * static_cast<size_t>(out.size()));
    sane_ = sane_ && out.allFinite();
    return out;
  }
  void doubt(bool fine) { sane_ = sane_ && fine; }
  uint32_t crc() const { return crc_.value(); }
  Status status() const {
    return status_ != Status::kOk ? status_ : sane_ ? Status::kOk : Status::kBadData;
  }

 private:
  MapSource source_;
  Crc32 crc_;
  Status status_ = Status::kOk;
  bool sane_ = true;
};

template <class Matrix>
void put_matrix(Writer& out, const Matrix& m) {
  out.bytes(m.data(), sizeof(double) * static_cast<size_t>(m.size()));
}

void put_point(Writer& out, const Landmark& point) {
  put_matrix(out, point.p_W);
  put_matrix(out, point.cov);
  put_matrix(out, point.view_W);
  out.put(point.descriptor);
  out.put(point.distance_m);
  out.put(point.first_keyframe);
  out.put(point.last_keyframe);
  out.put(uint32_t{point.epoch});
}

Landmark get_point(Reader& in) {
  Landmark out;
  out.p_W = in.matrix<Vec3>();
  out.cov = in.matrix<Mat3>();
  out.view_W = in.matrix<Vec3>();
  out.descriptor = in.get<Descriptor>();
  out.distance_m = in.get<float>();
  out.first_keyframe = in.get<uint32_t>();
  out.last_keyframe = in.get<uint32_t>();
  out.epoch = static_cast<uint16_t>(in.get<uint32_t>());
  in.doubt(std::isfinite(out.distance_m));
  return out;
}

void put_state(Writer& out, const BodyState& state) {
  out.put(state.t);
  put_matrix(out, state.T_WB.R);
  for (const Vec3* v : {&state.T_WB.p, &state.v_WB, &state.b_g, &state.b_a}) put_matrix(out, *v);
}

BodyState get_state(Reader& in) {
  BodyState out;
  out.t = in.get<TimeNs>();
  out.T_WB.R = in.matrix<Mat3>();
  for (Vec3* v : {&out.T_WB.p, &out.v_WB, &out.b_g, &out.b_a}) *v = in.matrix<Vec3>();
  in.doubt((out.T_WB.R.transpose() * out.T_WB.R - Mat3::Identity()).norm() < 1e-6);
  return out;
}

// Only what shows a point that lives is of use later.
void put_observations(Writer& out, const Observations (&observations)[kCamerasMax],
                      const uint32_t* saved_as, const Map& map) {
  int16_t kept[kCamerasMax][kTracksMax];
  uint32_t count[kCamerasMax] = {};
  for (int c = 0; c < kCamerasMax; ++c) {
    for (size_t i = 0; i < observations[c].size(); ++i) {
      const bool lives = map.landmarks.find(observations[c][i].landmark) != nullptr;
      kept[c][i] = lives ? static_cast<int16_t>(count[c]++) : int16_t{-1};
    }
  }
  for (int c = 0; c < kCamerasMax; ++c) {
    out.put(count[c]);
    for (size_t i = 0; i < observations[c].size(); ++i) {
      const Observation& o = observations[c][i];
      if (kept[c][i] < 0) continue;
      out.put(saved_as[o.landmark.slot]);
      out.put(o.x);
      out.put(o.y);
      const int16_t other = o.stereo < 0 ? int16_t{-1} : kept[1 - c][o.stereo];
      out.put(int32_t{other});
      out.put(uint32_t{o.described});
      out.put(o.descriptor);
    }
  }
}

Status get_observations(Reader& in, Map& map, uint32_t points, Observations (&out)[kCamerasMax]) {
  for (int c = 0; c < kCamerasMax; ++c) {
    const uint32_t count = in.get<uint32_t>();
    if (count > kTracksMax) return Status::kBadData;
    for (uint32_t i = 0; i < count; ++i) {
      Observation& o = *out[c].append();
      o = Observation{};
      const uint32_t point = in.get<uint32_t>();
      if (point >= points) return Status::kBadData;
      o.landmark = map.landmarks.handle(point);  // an empty pool fills its slots in order
      ++map.landmarks.at(point)->views;
      o.x = in.get<float>();
      o.y = in.get<float>();
      o.stereo = static_cast<int16_t>(in.get<int32_t>());
      o.described = in.get<uint32_t>() != 0;
      o.descriptor = in.get<Descriptor>();
      in.doubt(std::isfinite(o.x) && std::isfinite(o.y) && o.stereo >= -1);
    }
  }
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Observation& o : out[c]) {
      in.doubt(o.stereo < static_cast<int>(out[1 - c].size()));
    }
  }
  return in.status();
}

// A keyframe by its sequence number.
void put_node(Writer& out, const Node& node, const Map& map) {
  out.put(node.name);
  out.put(map.keyframes.find(node.keyframe)->sequence);
  put_matrix(out, node.T_KN.R);
  put_matrix(out, node.T_KN.p);
}

Status get_node(Reader& in, Map& map) {
  Node* const node = map.nodes.append();
  if (node == nullptr) return Status::kBadData;
  *node = Node{};
  in.bytes(node->name, sizeof node->name);
  const uint32_t sequence = in.get<uint32_t>();
  node->T_KN.R = in.matrix<Mat3>();
  node->T_KN.p = in.matrix<Vec3>();
  node->name[kNodeName - 1] = '\0';
  for (size_t slot = 0; slot < map.keyframes.capacity(); ++slot) {
    const Keyframe* const keyframe = map.keyframes.at(slot);
    if (keyframe == nullptr || keyframe->sequence != sequence) continue;
    node->keyframe = map.keyframes.handle(slot);
  }
  in.doubt(map.keyframes.find(node->keyframe) != nullptr && is_node_name(node->name));
  in.doubt((node->T_KN.R.transpose() * node->T_KN.R - Mat3::Identity()).norm() < 1e-6);
  return in.status();
}

void put_payload(Writer& out, const Map& map, uint32_t* saved_as) {
  uint32_t points = 0;
  for (size_t slot = 0; slot < map.landmarks.capacity(); ++slot) {
    const Landmark* point = map.landmarks.at(slot);
    saved_as[slot] = point == nullptr ? kNoPoint : points++;
    if (point != nullptr) put_point(out, *point);
  }
  for (size_t slot = 0; slot < map.keyframes.capacity(); ++slot) {
    const Keyframe* keyframe = map.keyframes.at(slot);
    if (keyframe == nullptr) continue;
    out.put(keyframe->sequence);
    out.put(uint32_t{keyframe->epoch});
    out.put(uint32_t{keyframe->at_rest});
    put_state(out, keyframe->state);
    put_matrix(out, keyframe->error);
    put_matrix(out, keyframe->added);
    put_observations(out, keyframe->observations, saved_as, map);
  }
  for (const Node& node : map.nodes) put_node(out, node, map);
}

Status get_keyframe(Reader& in, uint32_t points, Map& map) {
  const Result<KeyframeId> id = map.keyframes.acquire();
  if (!id.ok()) return Status::kBadData;
  Keyframe& out = *map.keyframes.find(id.value());
  out.sequence = in.get<uint32_t>();
  out.epoch = static_cast<uint16_t>(in.get<uint32_t>());
  out.at_rest = in.get<uint32_t>() != 0;
  out.state = get_state(in);
  out.error = in.matrix<Mat6>();
  out.added = in.matrix<Mat6>();
  return get_observations(in, map, points, out.observations);
}

Status get_payload(Reader& in, const MapFileHeader& header, Map& map) {
  for (uint32_t i = 0; i < header.points; ++i) {
    const Result<LandmarkId> id = map.landmarks.acquire();
    if (!id.ok()) return Status::kBadData;
    *map.landmarks.find(id.value()) = get_point(in);
  }
  PIRVS_TRY(in.status());
  for (uint32_t i = 0; i < header.keyframes; ++i) PIRVS_TRY(get_keyframe(in, header.points, map));
  for (uint32_t i = 0; i < header.nodes; ++i) PIRVS_TRY(get_node(in, map));
  return in.status();
}

Status check_header(const MapFileHeader& header) {
  const bool ours = std::memcmp(header.magic, kMagic, sizeof kMagic) == 0 &&
                    (header.version == 1 || header.version == kVersion) &&
                    header.points <= kLandmarksMax && header.keyframes <= kKeyframesMax &&
                    header.nodes <= kNodesMax;
  return ours ? Status::kOk : Status::kBadData;
}

}  // namespace

Status save_map(const Map& map, const MapSink& sink, MapIndex& index) {
  Writer counter(nullptr);
  put_payload(counter, map, index.saved_as);
  MapFileHeader header = {};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.points = static_cast<uint32_t>(map.landmarks.size());
  header.keyframes = static_cast<uint32_t>(map.keyframes.size());
  header.nodes = static_cast<uint32_t>(map.nodes.size());
  header.payload_bytes = counter.count();
  Writer out(&sink);
  out.put(header);
  put_payload(out, map, index.saved_as);
  out.put(out.crc());
  out.flush();
  return out.status();
}

Status verify_map(const MapSource& source) {
  Reader in(source);
  const MapFileHeader header = in.get<MapFileHeader>();
  PIRVS_TRY(in.status());
  PIRVS_TRY(check_header(header));
  uint8_t block[kBlock];
  for (uint64_t left = header.payload_bytes; left > 0;) {
    const size_t part = left < kBlock ? static_cast<size_t>(left) : kBlock;
    in.bytes(block, part);
    PIRVS_TRY(in.status());
    left -= part;
  }
  const uint32_t sum = in.crc();
  if (in.get<uint32_t>() != sum) return Status::kBadData;
  return in.status();
}

Status load_map(const MapSource& source, Map& map) {
  PIRVS_ASSERT(map.landmarks.size() == 0 && map.keyframes.size() == 0);
  Reader in(source);
  const MapFileHeader header = in.get<MapFileHeader>();
  Status status = in.status();
  if (status == Status::kOk) status = check_header(header);
  if (status == Status::kOk) status = get_payload(in, header, map);
  const uint32_t sum = in.crc();
  if (status == Status::kOk && in.get<uint32_t>() != sum) status = Status::kBadData;
  if (status == Status::kOk) return status;
  map.~Map();  // in place: no stack could hold another
  new (&map) Map;
  return status;
}

}  // namespace pirvs
