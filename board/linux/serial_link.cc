#include "board/linux/serial_link.h"

#include <errno.h>
#include <unistd.h>

#include <algorithm>

#include "bsp/linux/tty.h"

namespace pirvs::board {

void SerialLink::configure(const char* path, const SerialStack& stack) {
  path_ = path;
  stack_ = stack;
}

// ---- coming and going --------------------------------------------------------------------------

bool SerialLink::open() {
  fd_ = bsp::tty_open(path_, 0);
  if (fd_ < 0) return false;
  reader_.clear();
  waiting_.clear();
  waiting_from_ = 0;
  ++counters_.opened;
  return true;
}

void SerialLink::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void SerialLink::poll(TimeNs now) {
  if (!wanted()) return;
  if (fd_ < 0) {
    if (now < retry_t_) return;
    retry_t_ = now + kRetry_ns;
    if (!open()) return;
  }
  if (now < read_t_) return;
  read_t_ = now + kRead_ns;
  flush();
  read_lines();
}

// ---- out ---------------------------------------------------------------------------------------

// How many of the bytes there was room for.
size_t SerialLink::write_some(const char* data, size_t size) {
  const ssize_t written = fd_ < 0 ? 0 : write(fd_, data, size);
  if (written < 0 && errno != EAGAIN && errno != EINTR) close();
  return written > 0 ? static_cast<size_t>(written) : 0;
}

void SerialLink::flush() {
  const size_t left = waiting_.size() - waiting_from_;
  if (left == 0) return;
  waiting_from_ += write_some(waiting_.c_str() + waiting_from_, left);
  if (waiting_from_ < waiting_.size()) return;
  waiting_.clear();
  waiting_from_ = 0;
}

void SerialLink::write_line(const TextWriter& line, bool may_wait) {
  flush();
  if (fd_ < 0) return;
  const bool first = waiting_.size() == 0;
  const size_t written = first ? write_some(line.c_str(), line.size()) : 0;
  if (written == 0 && (!may_wait || line.size() > waiting_.room())) {
    counters_.dropped += fd_ >= 0;
    return;
  }
  ++counters_.lines;
  if (written < line.size()) waiting_.put(line.c_str() + written);
}

void SerialLink::pose(const TextWriter& line) {
  if (!wanted()) return;
  newest_.clear();
  newest_.put(line.c_str());
  if (poses_) write_line(line, false);
}

void SerialLink::say(TextWriter& line) {
  line.put('\n');
  write_line(line, true);
}

void SerialLink::answer(const Answer& answer) {
  uint32_t* const end = tickets_ + kTicketsMax;
  uint32_t* const found = std::find(tickets_, end, answer.ticket + 1);
  if (found == end) return;
  *found = 0;
  Text<128> line;
  put_answer(line, answer);
  say(line);
}

// ---- in ----------------------------------------------------------------------------------------

void SerialLink::read_lines() {
  char bytes[256];
  const ssize_t got = fd_ < 0 ? 0 : read(fd_, bytes, sizeof bytes);
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) close();
  for (ssize_t i = 0; i < got; ++i) {
    const LineReader::Taken taken = reader_.take(bytes[i]);
    if (taken == LineReader::Taken::kMore) continue;
    if (taken == LineReader::Taken::kLine) {
      obey(reader_.line());
    } else if (!is_echo(reader_.line())) {
      ++counters_.garbled;
      Text<64> line;
      put_error(line, "a line that is too long, or no text");
      say(line);
    }
  }
}

void SerialLink::obey(std::string_view line) {
  const TextRequest request = read_request(line);
  if (request.kind == RequestKind::kNone) return;
  counters_.commands += request.kind != RequestKind::kBad;
  counters_.garbled += request.kind == RequestKind::kBad;
  obey(request);
}

void SerialLink::obey(const TextRequest& request) {
  TextWriter& line = answer_;
  line.clear();
  switch (request.kind) {
    case RequestKind::kNone:
      return;
    case RequestKind::kCommand:
      return command(request.command);
    case RequestKind::kBad:
      put_error(line, request.why);
      break;
    case RequestKind::kPose:
      line.put(newest_.size() > 0 ? "ok pose " : "error pose: there is none yet");
      for (const char* c = newest_.c_str(); *c != 0 && *c != '\n'; ++c) line.put(*c);
      break;
    case RequestKind::kCounters:
      line.put("ok counters");
      stack_.put_counters(stack_.context, line);
      break;
    case RequestKind::kPoses:
      poses_ = request.on;
      line.put("ok poses ").put(poses_ ? "on" : "off");
      break;
    case RequestKind::kHelp:
      put_help(line);
      break;
  }
  say(line);
}

void SerialLink::command(const Command& command) {
  uint32_t* const end = tickets_ + kTicketsMax;
  uint32_t* const free = std::find(tickets_, end, 0u);
  const Result<uint32_t> ticket =
      free != end ? stack_.command(stack_.context, command) : Result<uint32_t>(Status::kFull);
  if (ticket.ok()) {
    *free = ticket.value() + 1;
    return;
  }
  Text<128> line;
  put_answer(line, {0, command.kind, ticket.status(), SE3{}});
  say(line);
}

}  // namespace pirvs::board
