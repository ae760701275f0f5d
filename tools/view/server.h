// What    Serves the page and its messages: HTTP and WebSocket on one port, a thread of its own.
// In      The scene; the page, one file; who obeys commands.
// Out     To each page all that the scene holds, then its news, 60 times a second.
// Errors  InputError: the port is taken. A page that is slow loses states, frames and
//         images (counted, and told to it); one that is kBehindMax behind is cut off, and comes
//         back by itself. Pages of other sites are refused: what they ask for has their Origin.
// Cost    the thread rests while there is no page.
// Source  libwebsockets.org; RFC 6455.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <string>
#include <thread>
#include <vector>

#include "tools/view/scene.h"

struct lws;
struct lws_context;

namespace pirvs::tools {

struct ViewServerOptions {
  std::string bind = "127.0.0.1";  // an address of this machine
  int port = 8123;                 // 0: one that is free
  std::string page;                // file
};

class ViewServer {
 public:
  static constexpr size_t kBehindMax = 32U << 20;  // bytes
  // A line of a page's commands, and the number under which the page wants its answer; from the
  // server's thread.
  using Obey = std::function<void(const std::string& id, const std::string& line)>;

  ViewServer(const ViewServerOptions& options, Scene& scene, Obey obey);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  int port() const { return port_; }
  std::string address() const;
  int pages() const { return pages_; }  // that look now, any thread

  // libwebsockets' events; 0, or -1 to end that connection.
  struct Page;
  int on_http(lws* wsi, const char* path);
  bool may_connect(lws* wsi) const;
  void on_come(lws* wsi);
  void on_gone(lws* wsi);
  int on_writable(lws* wsi);
  int on_text(lws* wsi, const char* data, size_t size, bool whole);

 private:
  void run();
  void round();
  void send(Page& page, const ViewMessage& message);
  void obey(Page& page, const std::string& text);
  Page* find(const lws* wsi);

  ViewServerOptions options_;
  Scene& scene_;
  Obey obey_;
  int port_ = 0;
  lws_context* context_ = nullptr;
  std::list<Page> clients_;  // the server's thread alone
  std::atomic<int> pages_{0};
  std::atomic<bool> stop_{false};
  TimeNs load_t_ = 0;  // of the next message on each page
  std::thread thread_;
};

}  // namespace pirvs::tools
