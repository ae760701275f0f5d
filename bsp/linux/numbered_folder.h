// A new folder in another one, named by a number that goes on over starts of the program and of the
// machine, whatever the clock says: 0001, 0002 and so on.
// In      An existing folder.
// Out     The name of the folder that was made: one more than the highest number there, of four
//         digits at least. What is there is left as it is, whatever it is.
// Errors  kNotFound: no such folder. kFull: the disk is full. kBusFault: all else, permissions too.
// Cost    No heap. Reads all names of the folder.
// Source  getdents64(2), mkdir(2).
#pragma once

#include "core/base/status.h"
#include "core/base/text.h"

namespace pirvs::bsp {

Status make_numbered_folder(const char* in, TextWriter& name);

}  // namespace pirvs::bsp
