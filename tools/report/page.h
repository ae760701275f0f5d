// What    The frame of an HTML page that needs nothing but itself: style, script, escaping.
// In      Title and body.
// Out     A whole document, light or dark as the reader's system is (or by the button).
// Errors  none.
#pragma once

#include <string>

namespace pirvs::tools {

std::string html_escape(const std::string& text);
std::string html_page(const std::string& title, const std::string& body);

}  // namespace pirvs::tools
