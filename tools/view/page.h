// What    Files of the view: its page, a page with a run in it, an earlier map.
// In      The page lies beside the program: build/host/pirvs and build/view/view.html, or bin/pirvs
//         and share/pirvs/view.html.
// Out     save_page(): the page with those messages in it, one file that needs nothing else.
//         read_ply(): places of a PLY file of text, as `pirvs run` writes it: its first three
//         properties are x y z. read_points(): of such a file, or of a saved map.
// Errors  InputError: the page is not built, a file cannot be written, not such a PLY, not a map.
// Source  docs/view.md.
#pragma once

#include <string>
#include <vector>

#include "tools/view/message.h"

namespace pirvs::tools {

std::string page_file();
void save_page(const std::vector<ViewMessage>& messages, const std::string& path);
std::vector<Eigen::Vector3f> read_ply(const std::string& path);
std::vector<Eigen::Vector3f> read_points(const std::string& path);

}  // namespace pirvs::tools
