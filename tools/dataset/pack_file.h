// What    A recording packed into one file, as bsp/replay/pack.h describes it, and back.
// In      write_pack: an open Recording of two cameras. open_pack: the file.
// Out     write_pack: the file, whole or not at all, and its size. open_pack: a Recording whose
//         frames point into the file's memory, which it keeps. GNSS fixes go along, the truth does
//         not.
// Errors  InputError: cannot read or write; no pack, another version, cut off or damaged.
// Cost    decoding, 7 ms a stereo frame of 752 x 480; 0.7 MB of memory and disk each.
// Source  bsp/replay/pack.h.
#pragma once

#include <functional>
#include <string>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

// on_frame(done, total) is called after each frame.
size_t write_pack(const Recording& recording, const std::string& path,
                  const std::function<void(size_t, size_t)>& on_frame);
Recording open_pack(const std::string& path);

}  // namespace pirvs::tools
