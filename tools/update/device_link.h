// What    A connection to a device's receiver of updates: lines, and a bundle.
// In      HOST or HOST:PORT, by name or address.
// Out     send, send_file, read_line as they say.
// Errors  InputError: no such host, no such file. LinkError: the device does not answer, or the
//         connection broke. read_line: false at the end of the connection.
// Cost    what the network costs. A device that is gone is noticed within half a minute, one that
//         says nothing within kSilence_s_max.
// Source  board/card/receive/lines.h.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace pirvs::tools {

inline constexpr int kUpdatePort = 4711;

struct LinkError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class DeviceLink {
 public:
  explicit DeviceLink(const std::string& host);
  ~DeviceLink();
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  void send(const std::string& text);
  // Ends early when the device has something to say.
  void send_file(const std::string& path, uint64_t bytes,
                 const std::function<void(uint64_t)>& progress);
  bool read_line(std::string& out);

 private:
  static constexpr int kConnect_s_max = 5, kSilence_s_max = 600;

  bool has_input() const;

  std::string host_;
  int fd_ = -1;
  std::string pending_;
};

}  // namespace pirvs::tools
