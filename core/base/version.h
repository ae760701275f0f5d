// Which version this is: 1.2+3.gHASH, by the tag (tools/setup/version).
// Source  version.cc, which make writes below build/: the one object that depends on the revision.
#pragma once

namespace pirvs {

extern const char kVersion[];

}  // namespace pirvs
