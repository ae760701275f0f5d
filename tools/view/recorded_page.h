// What    The page with messages in it that it shows instead of asking a server: one document that
//         needs nothing else.
// In      All that a scene holds.
// Out     HTML. What other sites' pages could not do to it, nothing in the messages can: they are
//         base64.
// Errors  InputError: the page is not built.
// Cost    0.65 MB, and 4/3 of the messages.
#pragma once

#include <string>
#include <vector>

#include "tools/view/message.h"

namespace pirvs::tools {

std::string recorded_page(const std::vector<ViewMessage>& messages);

}  // namespace pirvs::tools
