#include "board/linux/stream_output.h"

#include <algorithm>
#include <cstring>

#include "bsp/api/clock.h"
#include "bsp/api/events.h"
#include "bsp/linux/datagram.h"
#include "bsp/linux/events.h"

namespace pirvs::board {
namespace {

using stream::Kind;

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr int kThumbnailStep = 4;  // every fourth pixel of every fourth row
constexpr int kSeenMax = 4 * stream::kPointsMax;

}  // namespace

const char* StreamOutput::open(bsp::Endpoint own, const App& app,
                               void (*for_each_counter)(VisitValue, void*)) {
  const Result<bsp::Socket> socket = bsp::datagram_open(own);
  if (!socket.ok()) return "cannot bind that address and port: in use, or no permission";
  socket_ = socket.value();
  open_ = true;
  app_ = &app;
  for_each_counter_ = for_each_counter;
  (void)bsp::watch_fd(0, bsp::datagram_fd(socket_));
  return nullptr;
}

void StreamOutput::close() {
  if (!open_) return;
  bsp::forget_fd(0, bsp::datagram_fd(socket_));
  bsp::datagram_close(socket_);
  open_ = false;
}

// ---- requests ----------------------------------------------------------------------------------

void StreamOutput::subscribe(const bsp::Endpoint& from, const stream::SubscribeMessage& message) {
  Subscriber* slot = nullptr;
  for (Subscriber& other : subscribers_) {
    const bool same = other.to.address == from.address && other.to.port == from.port;
    if (same) slot = &other;
    if (slot == nullptr && other.until_t < now_) slot = &other;
  }
  if (slot == nullptr) {
    ++counters_.refused;
    return;
  }
  const bool same = slot->to.address == from.address && slot->to.port == from.port;
  if (!same || slot->until_t < now_) slot->sequence = 0;
  slot->to = from;
  slot->kinds = message.kinds;
  slot->until_t = now_ + std::min<TimeNs>(message.lease_s, kLeaseMax_s) * kSecond_ns;
}

void StreamOutput::take_requests() {
  constexpr int kAtOnce = 16;  // whoever floods us must not hold up the door
  for (int i = 0; i < kAtOnce; ++i) {
    uint8_t request[stream::kMax];
    size_t size = 0;
    bsp::Endpoint from;
    const Status status = bsp::datagram_receive(socket_, request, sizeof request, size, from);
    if (status != Status::kOk) return;
    stream::Header header;
    stream::SubscribeMessage wanted;
    stream::ClockMessage asked;
    const uint8_t* const payload = request + stream::kHeaderBytes;
    if (!stream::decode(request, size, header)) {
      ++counters_.bad_requests;
    } else if (stream::decode(header, payload, wanted)) {
      subscribe(from, wanted);
    } else if (header.kind == Kind::kAskClock && stream::decode(header, payload, asked)) {
      asked.t_device = bsp::now();
      const size_t answer = stream::encode(asked, Kind::kClock, 0, bytes_);
      (void)bsp::datagram_send(socket_, from, bytes_, answer);
    } else {
      ++counters_.bad_requests;
    }
  }
}

// ---- answers -----------------------------------------------------------------------------------

bool StreamOutput::anybody_wants(Kind kind) const {
  return std::any_of(std::begin(subscribers_), std::end(subscribers_), [&](const Subscriber& one) {
    return one.until_t >= now_ && (one.kinds & stream::bit(kind)) != 0;
  });
}

void StreamOutput::send(Subscriber& subscriber, size_t size) {
  if (bsp::datagram_send(socket_, subscriber.to, bytes_, size) == Status::kOk) {
    ++counters_.sent;
  } else {
    ++counters_.dropped;
  }
}

// `encode`: of a sequence number, into bytes_, its size.
template <class Encode>
void StreamOutput::send_all(Kind kind, Encode encode) {
  for (Subscriber& one : subscribers_) {
    if (one.until_t < now_ || (one.kinds & stream::bit(kind)) == 0) continue;
    send(one, encode(one.sequence++));
  }
}

void StreamOutput::pose(const Pose& pose) {
  if (!open_) return;
  send_all(Kind::kPose, [&](uint32_t sequence) { return stream::encode(pose, sequence, bytes_); });
}

void StreamOutput::health(TimeNs t, HealthState state, const char* why) {
  if (!open_) return;
  stream::HealthMessage message;
  message.t = t;
  message.health = state;
  message.why.put(why);
  send_all(Kind::kHealth,
           [&](uint32_t sequence) { return stream::encode(message, sequence, bytes_); });
}

void StreamOutput::event(const SyncEvent& event) {
  if (!open_) return;
  const Pose* const pose = event.has_pose ? &event.pose : nullptr;
  send_all(Kind::kSyncIn, [&](uint32_t sequence) {
    return stream::encode(event.edge.t, event.edge.level, pose, sequence, bytes_);
  });
}

void StreamOutput::pps(const bsp::Pps& pps) {
  if (!open_) return;
  const stream::PpsMessage message = {pps.second_t(), pps.rate_ppb(),
                                      static_cast<float>(pps.noise_ns()), pps.pulses(), pps.odd()};
  send_all(Kind::kPps,
           [&](uint32_t sequence) { return stream::encode(message, sequence, bytes_); });
}

void StreamOutput::fused(const FusedPose& pose) {
  if (!open_) return;
  send_all(Kind::kFused, [&](uint32_t sequence) { return stream::encode(pose, sequence, bytes_); });
}

void StreamOutput::imu(const ImuSample& sample) {
  if (!open_) return;
  send_all(Kind::kImu, [&](uint32_t sequence) { return stream::encode(sample, sequence, bytes_); });
}

void StreamOutput::frame(const StereoFrame& frame) {
  if (!open_ || now_ < thumbnail_t_ || !anybody_wants(Kind::kThumbnail)) return;
  const ImageView& image = (frame.present & 1) != 0 ? frame.image[0] : frame.image[1];
  if (image.data == nullptr) return;
  thumbnail_t_ = now_ + kSecond_ns / 2;
  stream::ThumbnailMessage message;
  message.t = frame.t;
  message.width = static_cast<uint16_t>(image.width / kThumbnailStep);
  message.height = static_cast<uint16_t>(image.height / kThumbnailStep);
  const size_t pixels = size_t{message.width} * message.height;
  stream::Header header;
  header.kind = Kind::kThumbnail;
  header.parts = static_cast<uint16_t>((pixels + stream::kPixelsMax - 1) / stream::kPixelsMax);
  for (size_t at = 0; at < pixels; ++header.part) {
    message.offset = static_cast<uint32_t>(at);
    message.count = static_cast<uint16_t>(std::min(stream::kPixelsMax, pixels - at));
    for (int i = 0; i < message.count; ++i, ++at) {
      const int x = static_cast<int>(at % message.width), y = static_cast<int>(at / message.width);
      message.pixels[i] = image.row(y * kThumbnailStep)[x * kThumbnailStep];
    }
    send_all(Kind::kThumbnail, [&](uint32_t sequence) {
      header.sequence = sequence;
      return stream::encode(message, header, bytes_);
    });
  }
}

void StreamOutput::send_counters() {
  constexpr size_t kTextMax = stream::kMax - stream::kHeaderBytes;
  struct Sender {
    StreamOutput* self;
    Text<kTextMax> text;
    stream::Header header;
    bool measure;  // how many parts there are

    void flush() {
      if (!measure) {
        self->send_all(Kind::kCounters, [this](uint32_t sequence) {
          header.sequence = sequence;
          return stream::encode_text(text, header, self->bytes_);
        });
      }
      ++header.part;
      text.clear();
    }
    void add(const char* name, uint64_t value) {
      constexpr size_t kNumberMax = 24;
      if (text.size() + std::strlen(name) + kNumberMax >= kTextMax) flush();
      text.put(name).put(' ').unsigned_number(value).put('\n');
    }
  };
  Sender sender{this, {}, {}, true};
  sender.header.kind = Kind::kCounters;
  const auto visit = [](void* context, const char* name, uint64_t value) {
    static_cast<Sender*>(context)->add(name, value);
  };
  for (const bool measure : {true, false}) {
    sender.measure = measure;
    sender.header.part = 0;
    for_each_counter_(visit, &sender);
    sender.flush();
    sender.header.parts = sender.header.part;
  }
}

void StreamOutput::send_points() {
  SeenPoint seen[kSeenMax];
  const int count = app_->seen_points(seen, kSeenMax);
  stream::Header header;
  header.kind = Kind::kPoints;
  header.parts =
      static_cast<uint16_t>(std::max(1, (count + stream::kPointsMax - 1) / stream::kPointsMax));
  stream::PointsMessage message;
  message.t = now_;
  for (int at = 0; header.part < header.parts; ++header.part) {
    message.count = std::min(stream::kPointsMax, count - at);
    for (int i = 0; i < message.count; ++i, ++at) {
      const SeenPoint& point = seen[at];
      message.points[i] = {point.id.generation << 13 | point.id.slot, point.p_W.cast<float>(),
                           static_cast<float>(point.sigma_m)};
    }
    send_all(Kind::kPoints, [&](uint32_t sequence) {
      header.sequence = sequence;
      return stream::encode(message, header, bytes_);
    });
  }
}

void StreamOutput::poll() {
  if (!open_) return;
  now_ = bsp::now();
  if (bsp::take_ready(0, bsp::datagram_fd(socket_)) || now_ >= look_t_) {
    look_t_ = now_ + kLook_ns;
    take_requests();
  }
  if (now_ >= counters_t_ && anybody_wants(Kind::kCounters)) {
    counters_t_ = now_ + kSecond_ns;
    send_counters();
  }
  if (now_ >= points_t_ && anybody_wants(Kind::kPoints)) {
    points_t_ = now_ + kSecond_ns / 2;
    send_points();
  }
}

}  // namespace pirvs::board
