#include "tools/view/serial_commands.h"

#include <poll.h>
#include <unistd.h>

#include "bsp/api/clock.h"
#include "bsp/linux/tty.h"

namespace pirvs::tools {
namespace {

constexpr size_t kQuestionsMax = 16, kLineMax = 16384;

bool is_answer(const std::string& line) {
  return line.rfind("ok", 0) == 0 || line.rfind("error", 0) == 0;
}

bool write_all(int fd, const std::string& text) {
  size_t done = 0;
  while (done < text.size()) {
    pollfd ready{fd, POLLOUT, 0};
    constexpr int kPatience_ms = 1000;
    if (poll(&ready, 1, kPatience_ms) <= 0) return false;
    const ssize_t put = write(fd, text.data() + done, text.size() - done);
    if (put <= 0) return false;
    done += static_cast<size_t>(put);
  }
  return true;
}

}  // namespace

SerialCommands::SerialCommands(std::string path, Answer answer)
    : path_(std::move(path)), answer_(std::move(answer)), thread_([this] { run(); }) {}

SerialCommands::~SerialCommands() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  if (fd_ >= 0) close(fd_);
}

void SerialCommands::ask(const std::string& id, const std::string& line) {
  {
    const std::lock_guard lock(mutex_);
    if (questions_.size() < kQuestionsMax) {
      questions_.push_back({id, line});
      wake_.notify_one();
      return;
    }
  }
  answer_(id, "error too many commands wait");
}

void SerialCommands::run() {
  for (;;) {
    Question question;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !questions_.empty(); });
      if (stop_) return;
      question = questions_.front();
      questions_.pop_front();
    }
    answer_(question.id, answer_to(question.line));
  }
}

// A line that was begun by another is ended first; poses would stand between the answers.
bool SerialCommands::open() {
  if (fd_ >= 0) return true;
  fd_ = bsp::tty_open(path_.c_str(), 0);
  if (fd_ < 0) return false;
  if (write_all(fd_, "\r\nposes off\r\n") && !read_answer().empty()) return true;
  close(fd_);
  fd_ = -1;
  return false;
}

std::string SerialCommands::answer_to(const std::string& line) {
  for (const char c : line) {
    if (c < ' ' || c > '~') return "error a letter that a line cannot hold";
  }
  const bool was_open = fd_ >= 0;
  for (int attempt = was_open ? 0 : 1; attempt < 2; ++attempt) {  // it may have gone and come
    if (!open()) return "error no device answers at " + path_;
    if (write_all(fd_, line + "\r\n")) {
      const std::string answer = read_answer();
      if (!answer.empty()) return answer;
    }
    close(fd_);
    fd_ = -1;
  }
  return "error no answer";
}

// Empty: none came, or the line is gone.
std::string SerialCommands::read_answer() {
  std::string line;
  const TimeNs end = bsp::now() + kPatience_ns;
  for (TimeNs now = bsp::now(); now < end; now = bsp::now()) {
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return "";
    }
    pollfd ready{fd_, POLLIN, 0};
    constexpr int kLook_ms = 200;
    if (poll(&ready, 1, kLook_ms) <= 0) continue;
    char c = 0;
    if (read(fd_, &c, 1) != 1) return "";
    if (c != '\r' && c != '\n') {
      if (line.size() < kLineMax) line += c;
      continue;
    }
    if (is_answer(line)) return line;
    line.clear();
  }
  return "";
}

}  // namespace pirvs::tools
