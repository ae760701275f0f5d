// What    Commands to a device by its serial line, as docs/device.md, "Commands", has them.
// In      The tty; ask(): a line, from any thread.
// Out     `answer` gets each line's answer, in order, from a thread of this.
// Errors  No tty, or no answer within kPatience_ns: an answer that begins with `error`.
// Cost    a thread that rests.
// Source  docs/device.md.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/time.h"

namespace pirvs::tools {

class SerialCommands {
 public:
  static constexpr TimeNs kPatience_ns = 10'000'000'000;
  using Answer = std::function<void(const std::string& id, const std::string& text)>;

  SerialCommands(std::string path, Answer answer);
  ~SerialCommands();
  SerialCommands(const SerialCommands&) = delete;
  SerialCommands& operator=(const SerialCommands&) = delete;

  void ask(const std::string& id, const std::string& line);

 private:
  struct Question {
    std::string id, line;
  };
  void run();
  std::string answer_to(const std::string& line);
  bool open();
  std::string read_answer();

  std::string path_;
  Answer answer_;
  int fd_ = -1;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Question> questions_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace pirvs::tools
