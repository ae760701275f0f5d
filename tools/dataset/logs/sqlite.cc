// The .db3 files of a rosbag2 folder.
#include <sqlite3.h>

#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/log_file.h"

namespace pirvs::tools {
namespace {

class Statement {
 public:
  Statement(sqlite3* db, const std::string& path, const char* sql) : db_(db), path_(path) {
    if (sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) fail();
    return result == SQLITE_ROW;
  }
  void find(int64_t id) {
    sqlite3_reset(statement_);
    sqlite3_bind_int64(statement_, 1, id);
  }
  int64_t number(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) const {
    const auto* const from = sqlite3_column_text(statement_, column);
    return from == nullptr ? "" : reinterpret_cast<const char*>(from);
  }
  Bytes bytes(int column) const {
    const void* const from = sqlite3_column_blob(statement_, column);
    return {static_cast<const uint8_t*>(from), size_t(sqlite3_column_bytes(statement_, column))};
  }

 private:
  sqlite3* db_;
  std::string path_;
  sqlite3_stmt* statement_ = nullptr;

  [[noreturn]] void fail() const {
    throw InputError("not a rosbag2 database, " + std::string(sqlite3_errmsg(db_)), path_,
                     "give the folder that ros2 bag record has written");
  }
};

struct Database {
  explicit Database(const std::string& file) : path(file) {
    const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(path.c_str(), &db, flags, nullptr) == SQLITE_OK) return;
    sqlite3_close(db);
    throw InputError("cannot read", path, "check the path and its permissions");
  }
  ~Database() {
    one.reset();
    sqlite3_close(db);
  }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  std::string path;
  sqlite3* db = nullptr;
  std::unique_ptr<Statement> one;  // a message by its id
};

class Sqlite : public LogFile {
 public:
  explicit Sqlite(const std::vector<std::string>& paths) {
    for (const std::string& path : paths) all_.push_back(std::make_unique<Database>(path));
  }
  const char* kind() const override { return "rosbag2, sqlite3"; }

  void scan(const std::function<void(const LogMessage&)>& visit) override {
    topics_.clear();
    for (size_t file = 0; file < all_.size(); ++file) {
      Database& database = *all_[file];
      std::vector<std::pair<int64_t, size_t>> ids;
      Statement topics(database.db, database.path,
                       "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
      while (topics.step()) {
        ids.emplace_back(topics.number(0), topics_.size());
        topics_.push_back({topics.text(1), ros1_type(topics.text(2)), true});
        if (topics.text(3) != "cdr") topics_.back().type += " as " + topics.text(3);
      }
      Statement rows(database.db, database.path,
                     "SELECT id, topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
      while (rows.step()) {
        for (const auto& [id, topic] : ids) {
          if (id != rows.number(1)) continue;
          LogMessage message;
          message.topic = topic;
          message.log_t = rows.number(2);
          message.bytes = rows.bytes(3);
          message.place = {file, uint64_t(rows.number(0)), message.bytes.size};
          visit(message);
        }
      }
    }
  }

  Bytes load(const LogPlace& place) override {
    if (place.chunk >= all_.size()) return {};
    Database& database = *all_[size_t(place.chunk)];
    if (!database.one) {
      database.one = std::make_unique<Statement>(database.db, database.path,
                                                 "SELECT data FROM messages WHERE id = ?");
    }
    database.one->find(int64_t(place.at));
    return database.one->step() ? database.one->bytes(0) : Bytes{};
  }

 private:
  std::vector<std::unique_ptr<Database>> all_;
};

}  // namespace

std::unique_ptr<LogFile> open_sqlite(const std::vector<std::string>& paths) {
  return std::make_unique<Sqlite>(paths);
}

}  // namespace pirvs::tools
