#include "tools/network/resolve.h"

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

Addresses resolve(const std::string& device, int port, int socket_type) {
  const size_t colon = device.rfind(':');
  const std::string host = device.substr(0, colon);
  const std::string service =
      colon == std::string::npos ? std::to_string(port) : device.substr(colon + 1);
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = socket_type;
  addrinfo* found = nullptr;
  const int why = getaddrinfo(host.c_str(), service.c_str(), &wanted, &found);
  if (why != 0) {
    throw InputError(std::string("no such host: ") + gai_strerror(why), device,
                     "name the device, pirvs.local, or its address, 192.168.7.1 by USB");
  }
  return Addresses(found, &freeaddrinfo);
}

}  // namespace pirvs::tools
