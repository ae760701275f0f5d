// What    A log of messages: a ROS 1 bag, a rosbag2 folder (sqlite3 or MCAP), an MCAP file.
// In      Its path.
// Out     Topics, and messages as bytes, in the order of the file; each can be loaded again by its
//         place.
// Units   log_t: when it was logged, ns since 1970.
// Errors  InputError: not readable, cut off before any message, a compression that is not known.
//         A file cut off behind whole messages is read up to there: cut_off().
// Cost    A scan unpacks each chunk once; load() keeps the chunk at hand.
// Source  ROS wiki, "Bags/Format/2.0"; rosbag2_storage_sqlite3's tables; mcap.dev, "Format
//         Specification" (docs/adr/0019).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace pirvs::tools {

struct LogTopic {
  std::string name;
  std::string type;  // "sensor_msgs/Imu"; ROS 2's "sensor_msgs/msg/Imu" is written the same
  bool cdr = false;  // ROS 2's encoding, else ROS 1's
};

struct Bytes {
  const uint8_t* data = nullptr;
  size_t size = 0;
};

// Where a message is: its chunk in the file, or 0, and the message in it.
struct LogPlace {
  uint64_t chunk = 0;
  uint64_t at = 0;
  uint64_t size = 0;
};

struct LogMessage {
  size_t topic = 0;  // in topics()
  TimeNs log_t = 0;
  Bytes bytes;  // until the next one
  LogPlace place;
};

class LogFile {
 public:
  virtual ~LogFile() = default;
  virtual const char* kind() const = 0;
  virtual void scan(const std::function<void(const LogMessage&)>& visit) = 0;
  virtual Bytes load(const LogPlace& place) = 0;  // until the next call

  const std::vector<LogTopic>& topics() const { return topics_; }
  bool cut_off() const { return cut_off_; }

 protected:
  std::vector<LogTopic> topics_;
  bool cut_off_ = false;
};

// By the first bytes, or a folder by its metadata.yaml; nullptr: no log.
std::unique_ptr<LogFile> open_log(const std::string& path);

// Each kind.
std::unique_ptr<LogFile> open_bag(const std::string& path);
std::unique_ptr<LogFile> open_mcap(const std::string& path);
std::unique_ptr<LogFile> open_sqlite(const std::vector<std::string>& paths);

// "sensor_msgs/msg/Imu" as "sensor_msgs/Imu".
std::string ros1_type(std::string type);

}  // namespace pirvs::tools
