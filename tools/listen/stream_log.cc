#include "tools/listen/stream_log.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tools/dataset/input_error.h"
#include "tools/dataset/trajectory.h"
#include "tools/run/files.h"
#include "tools/run/fused.h"

namespace pirvs::tools {
namespace {

using stream::Kind;
using Json = nlohmann::ordered_json;

std::string pose_columns(const stream::PoseMessage& pose) {
  std::string line = tum_line(pose.t, pose.p_WB, pose.q_xyzw);
  line.pop_back();  // its line end
  for (char& c : line) c = c == ' ' ? ',' : c;
  return line;
}

}  // namespace

void StreamLog::add(const Datagram& datagram) {
  ++totals_.datagrams;
  totals_.bytes += datagram.size;
  stream::Header header;
  if (!stream::decode(datagram.bytes, datagram.size, header)) {
    ++totals_.damaged;
    return;
  }
  if (header.kind == Kind::kClock) return;  // an answer has no sequence
  if (has_sequence_) {
    const auto step = static_cast<int32_t>(header.sequence - sequence_);
    if (step > 1) totals_.lost += static_cast<size_t>(step - 1);
  }
  has_sequence_ = true;
  sequence_ = header.sequence;
  const auto kind = static_cast<size_t>(header.kind);
  if (kind < totals_.of_kind.size()) ++totals_.of_kind[kind];
  if (!take(header, datagram.bytes + stream::kHeaderBytes)) ++totals_.damaged;
}

// False: damaged. Kinds that are not known are those of a newer device, and no fault.
bool StreamLog::take(const stream::Header& header, const uint8_t* payload) {
  switch (header.kind) {
    case Kind::kPose: {
      stream::PoseMessage pose;
      if (!decode(header, payload, pose)) return false;
      take_pose(pose);
      return true;
    }
    case Kind::kHealth: {
      stream::HealthMessage health;
      if (!decode(header, payload, health)) return false;
      health_.push_back({health.t, health.health, health.why.c_str()});
      return true;
    }
    case Kind::kPoints: {
      stream::PointsMessage points;
      if (!decode(header, payload, points)) return false;
      for (int i = 0; i < points.count; ++i) points_[points.points[i].id] = points.points[i];
      return true;
    }
    case Kind::kThumbnail: {
      stream::ThumbnailMessage part;
      if (!decode(header, payload, part)) return false;
      take_thumbnail(part);
      return true;
    }
    case Kind::kSyncIn: {
      stream::SyncInMessage edge;
      if (!decode(header, payload, edge)) return false;
      sync_in_.push_back(edge);
      return true;
    }
    case Kind::kPps: {
      stream::PpsMessage pps;
      if (!decode(header, payload, pps)) return false;
      pps_.push_back(pps);
      return true;
    }
    case Kind::kFused: {
      FusedPose pose;
      if (!decode(header, payload, pose)) return false;
      fused_.push_back(pose);
      return true;
    }
    case Kind::kCounters:
      take_counters(header, payload);
      return true;
    default:
      return true;
  }
}

void StreamLog::take_pose(const stream::PoseMessage& pose) {
  if (!poses_.empty() && poses_.back().epoch == pose.epoch) {
    path_m_ += (pose.p_WB - poses_.back().p_WB).norm();
  }
  poses_.push_back(pose);
}

void StreamLog::take_counters(const stream::Header& header, const uint8_t* payload) {
  std::istringstream lines(std::string(reinterpret_cast<const char*>(payload), header.size));
  std::string name;
  uint64_t value = 0;
  while (lines >> name >> value) counters_[name] = value;
}

// Parts of another image end the one before: what is missing of it was lost.
void StreamLog::take_thumbnail(const stream::ThumbnailMessage& part) {
  if (part.t != image_.t || part.width != image_.width || part.height != image_.height) {
    image_ = {part.t, part.width, part.height, {}, 0};
    image_.pixels.resize(size_t{part.width} * part.height);
  }
  std::copy_n(part.pixels, part.count, image_.pixels.begin() + part.offset);
  image_.filled += part.count;
  if (image_.filled != image_.pixels.size() || image_.pixels.empty()) return;
  ++thumbnails_;
  if (folder_.empty()) return;
  const std::filesystem::path folder = std::filesystem::path(folder_) / "thumbnails";
  std::filesystem::create_directories(folder);
  const cv::Mat pixels(image_.height, image_.width, CV_8U, image_.pixels.data());
  cv::imwrite((folder / (std::to_string(image_.t) + ".png")).string(), pixels);
}

void StreamLog::write(const std::string& source, const ClockOffset& clock) const {
  OutputFolder out(folder_);
  std::string trajectory;
  for (const auto& pose : poses_) trajectory += tum_line(pose.t, pose.p_WB, pose.q_xyzw);
  out.write("trajectory.tum", trajectory);
  const std::vector<FusedPose> fused = in_order(fused_);
  if (!fused.empty()) {
    out.write("fused.tum", fused_tum(fused));
    out.write("fused.csv", fused_csv(fused));
  }
  std::string health = "#t_ns,state,why\n";
  for (const Health& row : health_) {
    health += std::to_string(row.t) + "," + name(row.state) + "," + row.why + "\n";
  }
  out.write("health.csv", health);
  std::string sync_in = "#t_ns,level,t_s,px,py,pz,qx,qy,qz,qw\n";
  for (const auto& edge : sync_in_) {
    sync_in += std::to_string(edge.t) + (edge.level ? ",1" : ",0");
    if (edge.has_pose) sync_in += "," + pose_columns(edge.pose);
    sync_in += "\n";
  }
  out.write("sync_in.csv", sync_in);
  std::string pps = "#t_ns,rate_ppb,noise_ns,pulses,odd\n";
  for (const auto& pulse : pps_) {
    char line[120];
    std::snprintf(line, sizeof line, "%lld,%.1f,%.0f,%u,%u\n", static_cast<long long>(pulse.t),
                  pulse.rate_ppb, double(pulse.noise_ns), pulse.pulses, pulse.odd);
    pps += line;
  }
  out.write("pps.csv", pps);
  std::string map = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points_.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const auto& [id, point] : points_) {
    char line[80];
    std::snprintf(line, sizeof line, "%g %g %g\n", double(point.p_W.x()), double(point.p_W.y()),
                  double(point.p_W.z()));
    map += line;
  }
  out.write("map.ply", map);
  Json counters = Json::object();
  for (const auto& [key, value] : counters_) counters[key] = value;
  const double duration_s = poses_.empty() ? 0 : to_seconds(poses_.back().t - poses_.front().t);
  const bool tracked = !poses_.empty() && poses_.back().health == HealthState::kTracking;
  Json summary = {{"status", tracked ? "tracked" : "lost"},
                  {"source", source},
                  {"duration_s", duration_s},
                  {"poses", poses_.size()},
                  {"path_m", path_m_},
                  {"fused_poses", fused.size()},
                  {"points", points_.size()},
                  {"sync_in_edges", sync_in_.size()},
                  {"thumbnails", thumbnails_},
                  {"datagrams", totals_.datagrams},
                  {"datagrams_lost", totals_.lost},
                  {"datagrams_damaged", totals_.damaged},
                  {"counters", counters}};
  if (clock.known) {
    summary["device_clock"] = {{"offset_ns", clock.offset_ns},
                               {"round_trip_ns", clock.round_trip_ns}};
  }
  if (!pps_.empty()) {
    summary["external_clock"] = {{"second_t_ns", pps_.back().t},
                                 {"rate_ppb", pps_.back().rate_ppb},
                                 {"noise_ns", pps_.back().noise_ns},
                                 {"pulses", pps_.back().pulses}};
  }
  out.write("summary.json", summary.dump(2) + "\n");
  out.commit();
}

}  // namespace pirvs::tools
