// What    What a device's stream has told, gathered into a run folder.
// In      Datagrams in the order in which they came.
// Out     Counts as they go; write(): trajectory.tum (every pose, at IMU rate), health.csv,
//         sync_in.csv, pps.csv, map.ply, thumbnails/NS.png, summary.json with its counters; with
//         GNSS fused.tum and fused.csv, as pirvs run writes them.
// Frames  as the stream.
// Errors  Datagrams that are none of ours, or damaged, are counted. write: InputError.
// Cost    ~150 bytes a pose in memory.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "modules/stream/stream.h"
#include "tools/listen/listener.h"

namespace pirvs::tools {

struct StreamTotals {
  size_t datagrams = 0, bytes = 0, damaged = 0;
  size_t lost = 0;  // by their sequence
  std::array<size_t, 64> of_kind{};
};

class StreamLog {
 public:
  // Thumbnails go into that folder as they are complete; empty: nowhere.
  explicit StreamLog(std::string folder = "") : folder_(std::move(folder)) {}

  void add(const Datagram& datagram);

  const StreamTotals& totals() const { return totals_; }
  const std::vector<stream::PoseMessage>& poses() const { return poses_; }
  const std::vector<FusedPose>& fused() const { return fused_; }
  const std::vector<stream::PpsMessage>& pps() const { return pps_; }
  const std::map<std::string, uint64_t>& counters() const { return counters_; }
  double path_m() const { return path_m_; }
  void write(const std::string& source, const ClockOffset& clock) const;

 private:
  struct Health {
    TimeNs t;
    HealthState state;
    std::string why;
  };
  struct Image {
    TimeNs t = 0;
    int width = 0, height = 0;
    std::vector<uint8_t> pixels;
    size_t filled = 0;
  };

  bool take(const stream::Header& header, const uint8_t* payload);
  void take_pose(const stream::PoseMessage& pose);
  void take_counters(const stream::Header& header, const uint8_t* payload);
  void take_thumbnail(const stream::ThumbnailMessage& part);

  std::string folder_;
  StreamTotals totals_;
  bool has_sequence_ = false;
  uint32_t sequence_ = 0;
  std::vector<stream::PoseMessage> poses_;
  std::vector<Health> health_;
  std::vector<stream::SyncInMessage> sync_in_;
  std::vector<stream::PpsMessage> pps_;
  std::vector<FusedPose> fused_;
  std::map<uint32_t, stream::Point> points_;  // newest place of each
  std::map<std::string, uint64_t> counters_;
  Image image_;
  size_t thumbnails_ = 0;
  double path_m_ = 0;
};

}  // namespace pirvs::tools
