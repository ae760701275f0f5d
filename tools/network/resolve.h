// What    The address of a device: HOST or HOST:PORT.
// In      The text; the port if it names none; SOCK_DGRAM or SOCK_STREAM.
// Out     An IPv4 address that connect() takes.
// Errors  InputError: no such host.
// Cost    a question to the resolver.
#pragma once

#include <netdb.h>

#include <memory>
#include <string>

namespace pirvs::tools {

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses resolve(const std::string& device, int port, int socket_type);

}  // namespace pirvs::tools
