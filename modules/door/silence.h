// How long somebody has said nothing, by a clock that is told from outside.
// Units   ns.
// Errors  none.
#pragma once

#include "core/base/time.h"

namespace pirvs {

class Silence {
 public:
  // Time passes, and nothing was heard.
  void tick(TimeNs now) {
    if (!lasting_) since_ = now;
    lasting_ = true;
    now_ = now;
  }
  void end() { *this = Silence{}; }
  bool lasts(TimeNs limit) const { return lasting_ && now_ - since_ >= limit; }
  // True once in a silence.
  bool is_news() {
    const bool news = !told_;
    told_ = true;
    return news;
  }

 private:
  TimeNs since_ = 0, now_ = 0;
  bool lasting_ = false;
  bool told_ = false;
};

}  // namespace pirvs
