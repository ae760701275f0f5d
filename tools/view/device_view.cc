#include "tools/view/device_view.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"
#include "tools/dataset/input_error.h"
#include "tools/listen/listener.h"
#include "tools/listen/stream_parts.h"
#include "tools/view/image_encoder.h"
#include "tools/view/serial_commands.h"
#include "tools/view/system_load.h"

namespace pirvs::tools {

using nlohmann::json;
using stream::Kind;

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr TimeNs kSilent_ns = 2'500'000'000;  // it answers once a second
constexpr TimeNs kLook_ns = 50'000'000;

uint32_t wanted_kinds() {
  uint32_t kinds = 0;
  for (const Kind kind : {Kind::kPose, Kind::kHealth, Kind::kCounters, Kind::kPoints,
                          Kind::kThumbnail, Kind::kFused}) {
    kinds |= stream::bit(kind);
  }
  return kinds;
}

// What has been told since the device was found.
class Session {
 public:
  explicit Session(ViewScene& scene) : scene_(scene) {}

  // False: this is not the device, or not the start, that the datagrams before were of.
  bool take(const Datagram& datagram, const Listener& listener);

 private:
  void take_pose(const stream::PoseMessage& pose, const Listener& listener, TimeNs arrival);
  void take_points(const stream::PointsMessage& points);
  void take_counters(const stream::Header& header, const uint8_t* payload);
  void take_thumbnail(const stream::ThumbnailMessage& part);

  ViewScene& scene_;
  TimeNs t_ = 0;
  SequenceGaps gaps_;
  uint64_t lost_ = 0, damaged_ = 0;
  std::map<std::string, uint64_t> counters_;
  ImageParts images_;
};

bool Session::take(const Datagram& datagram, const Listener& listener) {
  stream::Header header;
  if (!stream::decode(datagram.bytes, datagram.size, header)) {
    ++damaged_;
    return true;
  }
  if (header.kind == Kind::kClock) return true;
  lost_ += gaps_.next(header.sequence);
  const uint8_t* const payload = datagram.bytes + stream::kHeaderBytes;
  stream::PoseMessage pose;
  stream::HealthMessage health;
  stream::PointsMessage points;
  stream::ThumbnailMessage part;
  FusedPose fused;
  if (decode(header, payload, pose)) {
    if (pose.t + kSecond_ns < t_) return false;
    t_ = pose.t;
    take_pose(pose, listener, datagram.t_arrival);
  } else if (decode(header, payload, health)) {
    scene_.health(health.t, health.health, health.why.c_str());
  } else if (decode(header, payload, points)) {
    take_points(points);
  } else if (decode(header, payload, part)) {
    take_thumbnail(part);
  } else if (decode(header, payload, fused)) {
    scene_.fused(fused);
  } else if (header.kind == Kind::kCounters) {
    take_counters(header, payload);
  }
  return true;
}

void Session::take_pose(const stream::PoseMessage& pose, const Listener& listener, TimeNs arrival) {
  const ClockOffset& clock = listener.clock();
  ViewPose out;
  out.t = pose.t;
  out.host_t = listener.live() && clock.known ? pose.t - clock.offset_ns : arrival;
  out.t_published = pose.t_published;
  out.t_frame = pose.t_frame;
  out.p_WB = pose.p_WB;
  out.v_WB = pose.v_WB;
  out.w_B = pose.w_B;
  out.q_xyzw = pose.q_xyzw;
  out.sigma_theta = pose.cov_theta_p.diagonal().head<3>().cwiseMax(0).cwiseSqrt();
  out.sigma_p = pose.cov_theta_p.diagonal().tail<3>().cwiseMax(0).cwiseSqrt();
  out.sigma_v = pose.cov_v.diagonal().cwiseMax(0).cwiseSqrt();
  out.health = pose.health;
  out.confidence = pose.confidence;
  out.resets = pose.resets;
  out.epoch = pose.epoch;
  out.dead_reckoning = pose.dead_reckoning;
  out.in_map = pose.in_map;
  scene_.pose(out);
}

void Session::take_points(const stream::PointsMessage& points) {
  std::vector<ViewPoint> out;
  for (int i = 0; i < points.count; ++i) {
    const stream::Point& point = points.points[i];
    out.push_back({point.id, point.p_W, point.sigma_m});
  }
  scene_.points(out);
}

// Shown when all parts have come; what was lost of them stays as it was.
void Session::take_counters(const stream::Header& header, const uint8_t* payload) {
  read_counters(header, payload, counters_);
  if (header.part + 1 < header.parts) return;
  counters_["view.datagrams_lost"] = lost_;
  counters_["view.datagrams_damaged"] = damaged_;
  scene_.counters(counters_);
}

void Session::take_thumbnail(const stream::ThumbnailMessage& part) {
  const ImageParts::Image* const image = images_.add(part);
  if (image == nullptr) return;
  const cv::Mat pixels(image->height, image->width, CV_8UC1,
                       const_cast<uint8_t*>(image->pixels.data()));
  scene_.image({image->t, 0, image->width, image->height, view_jpeg(pixels), {}});
}

// A recorded stream comes as it came.
class Pace {
 public:
  void wait(const Listener& listener, const Datagram& datagram) {
    if (listener.live()) return;
    if (offset_ns_ == 0) offset_ns_ = bsp::now() - datagram.t_arrival;
    bsp::sleep_until(datagram.t_arrival + offset_ns_);
  }
  TimeNs offset_ns() const { return offset_ns_; }

 private:
  TimeNs offset_ns_ = 0;
};

// Until the device has gone, or has started anew (false), or `stop`.
bool listen_to(View& view, Listener& listener, Session& session,
               const volatile std::sig_atomic_t& stop) {
  SystemLoad load;
  TimeNs heard_t = bsp::now(), load_t = 0;
  Pace pace;
  const auto datagram = std::make_unique<Datagram>();
  while (stop == 0 && !listener.ended()) {
    const TimeNs now = bsp::now();
    if (now >= load_t) {
      load_t = now + kSecond_ns;
      view.scene().system(load.measure());
    }
    if (listener.next(*datagram, kLook_ns)) {
      pace.wait(listener, *datagram);
      if (!listener.live()) datagram->t_arrival += pace.offset_ns();
      heard_t = bsp::now();
      view.scene().source_is("connected", "");
      if (!session.take(*datagram, listener)) return false;
    } else if (now > heard_t + kSilent_ns) {
      return true;
    }
  }
  return true;
}

json source_of(const DeviceViewOptions& options) {
  json commands = json::array();
  if (!options.serial.empty()) {
    commands = {"stop",         "reset",       "pose",     "parameter", "map save",   "map load",
                "record start", "record stop", "node set", "node get",  "node remove"};
  }
  return {{"kind", "device"}, {"name", options.from}, {"commands", commands}};
}

}  // namespace

void view_device(View& view, const DeviceViewOptions& options,
                 const volatile std::sig_atomic_t& stop) {
  ViewScene& scene = view.scene();
  scene.begin(source_of(options));
  std::optional<SerialCommands> serial;
  if (!options.serial.empty()) {
    serial.emplace(options.serial, [&scene](const std::string& id, const std::string& text) {
      scene.answer(id, text);
    });
    view.obeyed_by(
        [&serial](const std::string& id, const std::string& line) { serial->ask(id, line); });
  }
  const bool is_file = std::filesystem::is_regular_file(options.from);
  std::optional<Session> session(std::in_place, scene);
  while (stop == 0) {
    try {
      Listener listener(options.from, wanted_kinds());
      if (!listen_to(view, listener, *session, stop)) {
        session.emplace(scene);
        scene.begin(source_of(options));
        continue;
      }
      if (listener.ended()) {
        scene.source_is("ended", "the recorded stream has ended");
        break;
      }
      if (stop == 0) scene.source_is("waiting", options.from + " does not answer");
    } catch (const InputError& error) {
      if (is_file) throw;
      scene.source_is("waiting", error.what());
      bsp::sleep_until(bsp::now() + kSecond_ns);
    }
  }
  view.obeyed_by(nullptr);
}

}  // namespace pirvs::tools
