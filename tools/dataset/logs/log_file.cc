#include "tools/dataset/logs/log_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

enum class Kind : uint8_t { kNone, kBag, kMcap, kSqlite };

Kind kind_of(const std::string& path) {
  char head[16] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  const std::string_view begin(head, sizeof head);
  if (begin.substr(0, 13) == "#ROSBAG V2.0\n") return Kind::kBag;
  if (begin.substr(0, 7) == "\x89MCAP0\r") return Kind::kMcap;
  if (begin.substr(0, 15) == "SQLite format 3") return Kind::kSqlite;
  if (begin.substr(0, 7) == "#ROSBAG") {
    throw InputError("a ROS bag of a version before 2.0", path, "run rosbag fix on it");
  }
  return Kind::kNone;
}

std::vector<std::string> files_with(const std::string& folder, const char* extension) {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == extension) out.push_back(entry.path().string());
  }
  // By length first: bag_10 comes behind bag_9.
  std::sort(out.begin(), out.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return out;
}

// The MCAP files of a folder, one behind the other.
class Several : public LogFile {
 public:
  explicit Several(const std::vector<std::string>& paths) {
    for (const std::string& path : paths) all_.push_back(open_mcap(path));
  }
  const char* kind() const override { return "rosbag2, MCAP"; }

  void scan(const std::function<void(const LogMessage&)>& visit) override {
    topics_.clear();
    places_.clear();
    for (size_t file = 0; file < all_.size(); ++file) {
      const size_t first = topics_.size();
      size_t known = 0;
      all_[file]->scan([&](const LogMessage& read) {
        const auto& topics = all_[file]->topics();
        for (; known < topics.size(); ++known) topics_.push_back(topics[known]);
        LogMessage message = read;
        message.topic += first;
        message.place = {file, places_.size(), read.place.size};
        places_.push_back(read.place);
        visit(message);
      });
      cut_off_ = cut_off_ || all_[file]->cut_off();
    }
  }
  Bytes load(const LogPlace& place) override {
    if (place.chunk >= all_.size() || place.at >= places_.size()) return {};
    return all_[size_t(place.chunk)]->load(places_[size_t(place.at)]);
  }

 private:
  std::vector<std::unique_ptr<LogFile>> all_;
  std::vector<LogPlace> places_;
};

}  // namespace

std::unique_ptr<LogFile> open_log(const std::string& path) {
  if (fs::is_directory(path)) {
    if (!fs::exists(path + "/metadata.yaml")) return nullptr;
    const auto databases = files_with(path, ".db3"), logs = files_with(path, ".mcap");
    if (!databases.empty()) return open_sqlite(databases);
    if (!logs.empty()) return std::make_unique<Several>(logs);
    return nullptr;
  }
  switch (kind_of(path)) {
    case Kind::kBag:
      return open_bag(path);
    case Kind::kMcap:
      return open_mcap(path);
    case Kind::kSqlite:
      return open_sqlite({path});
    case Kind::kNone:
      break;
  }
  return nullptr;
}

std::string ros1_type(std::string type) {
  for (const char* middle : {"/msg/", "::msg::", "::msg::dds_::"}) {
    const size_t at = type.find(middle);
    if (at != std::string::npos) type.replace(at, std::string(middle).size(), "/");
  }
  return type;
}

}  // namespace pirvs::tools
