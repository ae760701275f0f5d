// What    The page with messages in it that it shows instead of asking a server: one document that
//         needs nothing else.
// In      All that a scene holds.
// Out     HTML; the messages are base64, so that no name or text in them is read as a part of it.
// Errors  InputError: the page is not built.
// Cost    0.65 MB, and 4/3 of the messages.
#pragma once

#include <string>
#include <vector>

#include "tools/view/message.h"

namespace pirvs::tools {

std::string recorded_page(const std::vector<ViewMessage>& messages);

}  // namespace pirvs::tools
