#include "modules/door/command.h"

#include <iterator>

namespace pirvs {

const char* name(CommandKind kind) {
  static constexpr const char* kNames[] = {
      "stop",   "reset",          "set parameter", "set pose", "save map",   "load map",
      "record", "stop recording", "set node",      "get node", "remove node"};
  static_assert(std::size(kNames) == static_cast<size_t>(CommandKind::kCount));
  return kNames[static_cast<size_t>(kind)];
}

}  // namespace pirvs
