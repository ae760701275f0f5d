#include "tools/view/view.h"

#include <cstdio>
#include <cstdlib>

#include "tools/view/page.h"

namespace pirvs::tools {

namespace {

ViewServerOptions server_options(const ViewOptions& options) {
  return {options.bind, options.port, page_file()};
}

void open_browser(const std::string& address) {
  const std::string command = "xdg-open '" + address + "' >/dev/null 2>&1 &";
  if (std::system(command.c_str()) != 0) {
    std::fprintf(stderr, "pirvs: view: no browser could be opened\n");
  }
}

}  // namespace

std::vector<CLI::Option*> add_view_options(CLI::App& app, ViewOptions& options) {
  return {app.add_option("--port", options.port, "of the page; 0: any that is free")
              ->capture_default_str()
              ->check(CLI::Range(0, 65535)),
          app.add_option("--bind", options.bind,
                         "address of this machine for the page; any but the default lets others "
                         "look, and command")
              ->capture_default_str()
              ->check(CLI::ValidIPV4),
          app.add_flag("--open", options.open, "open the page in a browser"),
          app.add_option("--earlier-map", options.earlier_map,
                         "map.ply, or a saved map, of an earlier run, for the page")};
}

View::View(const ViewOptions& options)
    : server_(server_options(options), scene_,
              [this](const std::string& id, const std::string& line) { obey(id, line); }) {
  if (!options.earlier_map.empty()) scene_.earlier_map(read_points(options.earlier_map));
  std::fprintf(stderr, "pirvs: view: %s\n", server_.address().c_str());
  if (options.open) open_browser(server_.address());
}

void View::obeyed_by(ViewServer::Obey obey) {
  const std::lock_guard lock(mutex_);
  obey_ = std::move(obey);
}

void View::obey(const std::string& id, const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (obey_) return obey_(id, line);
  scene_.answer(id, "error nothing takes commands here");
}

}  // namespace pirvs::tools
