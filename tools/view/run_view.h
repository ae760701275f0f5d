// What    A finished run's folder, as a view shows it: all of it at once, for the page's slider.
// In      DIR of `pirvs run --out` or `pirvs listen --out`. `suffix`: of its files' names,
//         as long as they are written.
// Out     to the scene: the message "run", a row a frame; keyframes, points, health as it changed.
// Errors  InputError: no run there, a row that is none.
// Cost    ~1 s for an hour of frames.
#pragma once

#include <string>

#include "tools/view/scene.h"

namespace pirvs::tools {

bool is_run_folder(const std::string& path);
void show_run(ViewScene& scene, const std::string& folder, const std::string& suffix = "");

}  // namespace pirvs::tools
