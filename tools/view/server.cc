#include "tools/view/server.h"

#include <libwebsockets.h>

#include <algorithm>
#include <cstring>

#include "bsp/api/clock.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {

using nlohmann::json;

namespace {

constexpr lws_usec_t kRound_us = 1'000'000 / 60;
constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr size_t kTextMax = 4096;  // of what a page sends

constexpr char kHeaders[] = "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n";

std::string header_of(lws* wsi, lws_token_indexes token) {
  char text[300];
  const int size = lws_hdr_copy(wsi, text, sizeof text, token);
  return size > 0 ? std::string(text, static_cast<size_t>(size)) : "";
}

// What stands before the port.
std::string host_of(const std::string& authority) {
  if (!authority.empty() && authority[0] == '[')
    return authority.substr(0, authority.find(']') + 1);
  return authority.substr(0, authority.rfind(':'));
}

int on_event(lws* wsi, lws_callback_reasons reason, void*, void* in, size_t size) {
  if (wsi == nullptr) return 0;
  auto* const server = static_cast<ViewServer*>(lws_context_user(lws_get_context(wsi)));
  if (server == nullptr) return 0;
  switch (reason) {
    case LWS_CALLBACK_HTTP:
      return server->on_http(wsi, static_cast<const char*>(in));
    case LWS_CALLBACK_HTTP_FILE_COMPLETION:
      return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
      return server->may_connect(wsi) ? 0 : -1;
    case LWS_CALLBACK_ESTABLISHED:
      server->on_come(wsi);
      return 0;
    case LWS_CALLBACK_CLOSED:
      server->on_gone(wsi);
      return 0;
    case LWS_CALLBACK_SERVER_WRITEABLE:
      return server->on_writable(wsi);
    case LWS_CALLBACK_RECEIVE:
      return server->on_text(
          wsi, static_cast<const char*>(in), size,
          lws_is_final_fragment(wsi) != 0 && lws_remaining_packet_payload(wsi) == 0);
    default:
      return lws_callback_http_dummy(wsi, reason, nullptr, in, size);
  }
}

const lws_protocols kProtocols[] = {
    {"pirvs-view", on_event, 0, kTextMax, 0, nullptr, 0},
    {nullptr, nullptr, 0, 0, 0, nullptr, 0},
};

struct Round : lws_sorted_usec_list_t {
  bool due = false;
};

void on_round(lws_sorted_usec_list_t* list) { static_cast<Round*>(list)->due = true; }

}  // namespace

struct ViewServer::Page {
  lws* wsi = nullptr;
  std::list<ViewMessage> waiting;
  size_t waiting_bytes = 0;
  uint64_t dropped = 0;
  bool too_slow = false;
  std::string text;  // that has come in parts
};

ViewServer::ViewServer(const ViewServerOptions& options, Scene& scene, Obey obey)
    : options_(options), scene_(scene), obey_(std::move(obey)) {
  lws_set_log_level(0, nullptr);
  lws_context_creation_info info{};
  info.port = options_.port;
  info.iface = options_.bind.c_str();
  info.protocols = kProtocols;
  info.user = this;
  info.gid = info.uid = static_cast<decltype(info.gid)>(-1);
  info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_DISABLE_IPV6 |
                 LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  context_ = lws_create_context(&info);
  lws_vhost* const host = context_ != nullptr ? lws_create_vhost(context_, &info) : nullptr;
  if (host == nullptr) {
    if (context_ != nullptr) lws_context_destroy(context_);
    throw InputError(
        "cannot serve there", options_.bind + ":" + std::to_string(options_.port),
        "the port is taken, or the address not of this machine: choose another --port");
  }
  port_ = lws_get_vhost_listen_port(host);
  thread_ = std::thread([this] { run(); });
}

ViewServer::~ViewServer() {
  stop_ = true;
  lws_cancel_service(context_);
  thread_.join();
  lws_context_destroy(context_);
}

std::string ViewServer::address() const {
  const bool all = options_.bind == "0.0.0.0";
  return "http://" + (all ? std::string("127.0.0.1") : options_.bind) + ":" +
         std::to_string(port_) + "/";
}

void ViewServer::run() {
  Round next{};
  next.due = true;
  while (!stop_) {
    if (next.due) {
      next.due = false;
      round();
      lws_sul_schedule(context_, 0, &next, on_round, kRound_us);
    }
    lws_service(context_, 0);
  }
  lws_sul_schedule(context_, 0, &next, on_round, LWS_SET_TIMER_USEC_CANCEL);
}

void ViewServer::round() {
  const TimeNs now = bsp::now();
  const std::vector<ViewMessage> news = scene_.news(now);
  for (Page& page : clients_) {
    for (const ViewMessage& message : news) send(page, message);
  }
  if (now < load_t_) return;
  load_t_ = now + kSecond_ns;
  for (Page& page : clients_) {
    send(page, view_message({{"type", "page"},
                             {"pages", clients_.size()},
                             {"waiting_bytes", page.waiting_bytes},
                             {"dropped", page.dropped}}));
  }
}

void ViewServer::send(Page& page, const ViewMessage& message) {
  if (message.lossy()) {
    const auto same =
        std::find_if(page.waiting.begin(), page.waiting.end(),
                     [&](const ViewMessage& other) { return other.kind == message.kind; });
    if (same != page.waiting.end()) {
      page.waiting_bytes -= same->bytes->size();
      page.waiting.erase(same);
      ++page.dropped;
    }
  }
  page.waiting_bytes += message.bytes->size();
  page.too_slow = page.too_slow || page.waiting_bytes > kBehindMax;
  page.waiting.push_back(message);
  lws_callback_on_writable(page.wsi);
}

ViewServer::Page* ViewServer::find(const lws* wsi) {
  for (Page& page : clients_) {
    if (page.wsi == wsi) return &page;
  }
  return nullptr;
}

// ---- events of libwebsockets -------------------------------------------------------------------

int ViewServer::on_http(lws* wsi, const char* path) {
  const bool known = std::strcmp(path, "/") == 0;
  if (!known) {
    lws_return_http_status(wsi, HTTP_STATUS_NOT_FOUND, nullptr);
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
  }
  const int done = lws_serve_http_file(wsi, options_.page.c_str(), "text/html; charset=utf-8",
                                       kHeaders, sizeof kHeaders - 1);
  if (done < 0) return -1;
  return done > 0 && lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
}

// A page of another site that the same browser has open may ask this machine, too; it must not get
// anything, whatever name it has given to our address.
bool ViewServer::may_connect(lws* wsi) const {
  const std::string origin = header_of(wsi, WSI_TOKEN_ORIGIN);
  const std::string host = header_of(wsi, WSI_TOKEN_HOST);
  const std::string name = host_of(host);
  const bool of_ours = origin.empty() || origin == "http://" + host;
  const bool loopback = options_.bind.rfind("127.", 0) == 0;
  const bool named = name == "127.0.0.1" || name == "localhost" || name == options_.bind;
  return of_ours && (!loopback || named);
}

void ViewServer::on_come(lws* wsi) {
  // What has been told by now goes to the others as news, and to this one as a whole.
  const std::vector<ViewMessage> news = scene_.news(bsp::now());
  for (Page& page : clients_) {
    for (const ViewMessage& message : news) send(page, message);
  }
  Page& page = clients_.emplace_back();
  page.wsi = wsi;
  for (const ViewMessage& message : scene_.all()) send(page, message);
  pages_ = static_cast<int>(clients_.size());
}

void ViewServer::on_gone(lws* wsi) {
  clients_.remove_if([wsi](const Page& page) { return page.wsi == wsi; });
  pages_ = static_cast<int>(clients_.size());
}

int ViewServer::on_writable(lws* wsi) {
  Page* const page = find(wsi);
  if (page == nullptr || page->too_slow) return -1;
  while (!page->waiting.empty() && lws_send_pipe_choked(wsi) == 0) {
    const ViewMessage message = page->waiting.front();
    page->waiting.pop_front();
    page->waiting_bytes -= message.bytes->size();
    std::vector<unsigned char> bytes(LWS_PRE + message.bytes->size());
    std::memcpy(bytes.data() + LWS_PRE, message.bytes->data(), message.bytes->size());
    const auto protocol = message.binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT;
    if (lws_write(wsi, bytes.data() + LWS_PRE, message.bytes->size(), protocol) < 0) return -1;
  }
  if (!page->waiting.empty()) lws_callback_on_writable(wsi);
  return 0;
}

int ViewServer::on_text(lws* wsi, const char* data, size_t size, bool whole) {
  Page* const page = find(wsi);
  if (page == nullptr) return -1;
  page->text.append(data, size);
  if (page->text.size() > kTextMax) return -1;
  if (!whole) return 0;
  const std::string text = std::move(page->text);
  page->text.clear();
  obey(*page, text);
  return 0;
}

// What no page of ours says is nothing to anybody.
void ViewServer::obey(Page& page, const std::string& text) {
  const json said = json::parse(text, nullptr, false);
  if (!said.is_object()) return;
  const std::string type = said.value("type", json()).is_string() ? said["type"] : "";
  if (type == "ping" && said.contains("t") && said["t"].is_number()) {
    send(page,
         view_message({{"type", "pong"}, {"t", said["t"]}, {"host_t", view_time(bsp::now())}}));
  } else if (type == "forget") {
    scene_.forget();
  } else if (type == "command" && said.value("line", json()).is_string() &&
             said.value("id", json()).is_string()) {
    obey_(said["id"], said["line"]);
  }
}

}  // namespace pirvs::tools
