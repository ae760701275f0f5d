// What    The other end of a device's stream (modules/stream/stream.h): asks for it, takes it in.
// In      Host and port of the device; which kinds. Or a file that an earlier listener recorded.
// Out     next(): datagrams in the order in which they came, each with the time of this machine.
//         clock(): how this machine's clock stands to the device's, by the quickest answer.
// Units   ns; both clocks monotonic.
// Errors  InputError: no such host, no such file, a file that is none of ours. A device that does
//         not answer: next() gives nothing, heard() stays false.
// Cost    one system call a datagram.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "core/base/time.h"
#include "modules/stream/stream.h"

namespace pirvs::tools {

struct Datagram {
  TimeNs t_arrival = 0;
  size_t size = 0;
  uint8_t bytes[stream::kMax];
};

struct ClockOffset {
  bool known = false;
  TimeNs offset_ns = 0;  // device minus this machine
  TimeNs round_trip_ns = INT64_MAX;
};

class Listener {
 public:
  // "host", "host:port" or a file.
  Listener(const std::string& from, uint32_t kinds);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // Everything that comes from now on is also written to that file.
  void record(const std::string& path);

  // False: none came for `patience_ns`, or the file has ended (ended()).
  bool next(Datagram& out, TimeNs patience_ns);
  bool ended() const { return file_ != nullptr && at_end_; }
  bool heard() const { return heard_; }
  bool live() const { return file_ == nullptr; }
  const ClockOffset& clock() const { return clock_; }

 private:
  void connect_to(const std::string& device);
  void ask(TimeNs now);
  bool receive(Datagram& out, TimeNs patience_ns);
  bool read(Datagram& out);
  void write(const Datagram& datagram);
  void take_clock(const Datagram& datagram);

  uint32_t kinds_;
  int fd_ = -1;
  std::FILE* file_ = nullptr;
  std::FILE* record_ = nullptr;
  std::string record_path_;
  bool at_end_ = false, heard_ = false;
  TimeNs ask_t_ = 0;  // of the next request
  ClockOffset clock_;
};

}  // namespace pirvs::tools
