// What    A scene, the server that shows it, and whose commands the pages' buttons are.
// In      Where to serve; obeyed_by(): who takes a line of a command (board/linux/text_commands.h).
// Out     scene(), to be told; the address on stderr, and a browser if wanted.
// Errors  InputError: the port is taken, the page is not built, no such map.
// Source  docs/view.md.
#pragma once

#include <CLI/CLI.hpp>
#include <mutex>
#include <string>

#include "tools/view/scene.h"
#include "tools/view/server.h"

namespace pirvs::tools {

struct ViewOptions {
  std::string bind = "127.0.0.1";
  int port = 8123;
  bool open = false;
  std::string earlier_map;  // PLY, or a saved map
};
std::vector<CLI::Option*> add_view_options(CLI::App& app, ViewOptions& options);

class View {
 public:
  explicit View(const ViewOptions& options);
  ViewScene& scene() { return scene_; }
  const ViewServer& server() const { return server_; }
  // nullptr: nobody does. The answer is told to the scene, by the same id.
  void obeyed_by(ViewServer::Obey obey);

 private:
  void obey(const std::string& id, const std::string& line);

  ViewScene scene_;
  std::mutex mutex_;
  ViewServer::Obey obey_;
  ViewServer server_;
};

}  // namespace pirvs::tools
