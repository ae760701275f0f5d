// What    Calls visit(handle, item) for all that lives in a pool.
// Source  core/store/pool.h.
#pragma once

#include <cstddef>

namespace pirvs::tools {

template <class Pool, class Visit>
void for_each(Pool& pool, Visit&& visit) {
  for (size_t slot = 0; slot < pool.capacity(); ++slot) {
    if (auto* item = pool.at(slot)) visit(pool.handle(slot), *item);
  }
}

}  // namespace pirvs::tools
