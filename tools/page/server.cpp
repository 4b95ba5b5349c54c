// A viewer keeps one thread of the server, and there are more threads than viewers are let in: the
// emergency stop always finds one.
#include "tools/page/server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <chrono>
#include <stdexcept>
#include <thread>

#undef _res  // resolv.h makes a macro of what Eigen calls a parameter

#include "shared/wire/secure_channel.h"
#include "tools/page/embedded/bundle.h"

namespace sanso::page {
namespace {

constexpr std::size_t kThreads = 12, kMostViewers = 6;
constexpr std::size_t kMostAsked_bytes = 1024, kMostTaken_bytes = std::size_t{512} << 20;
constexpr Nanoseconds kKeepAlive = kSecond;
constexpr int kForbidden = 403, kBusy = 503, kRefused = 409;
// the page brings everything along; it may talk to nobody but its own server
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string new_token() {
  const wire::Key random = wire::random_key();
  std::string out;
  for (std::size_t i = 0; i < 16; ++i) out += fmt::format("{:02x}", random[i]);
  return out;
}

/// Takes the same time wherever they differ.
bool same(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i] ^ b[i]));
  return difference == 0;
}

}  // namespace

std::string event(const std::string& name, const std::string& data) {
  return fmt::format("event: {}\ndata: {}\n\n", name, data);
}

struct Server::Impl {
  Impl(int wanted, ServerContents what) : contents(std::move(what)), token(new_token()) {
    http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    // the library's own choice would let two programs share a port
    http.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    http.set_payload_max_length(contents.take ? kMostTaken_bytes : kMostAsked_bytes);
    http.set_keep_alive_max_count(4);
    http.set_keep_alive_timeout(1);
    http.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Content-Security-Policy", kPolicy}});
    http.set_pre_routing_handler([this](const auto& request, auto& response) {
      const std::string refusal = refused(request);
      if (refusal.empty()) return httplib::Server::HandlerResponse::Unhandled;
      response.status = kForbidden;
      response.set_content(refusal + "\n", "text/plain");
      return httplib::Server::HandlerResponse::Handled;
    });
    add_pages();
    add_events();
    add_control();
    if (contents.take)
      http.Post("/take/([a-z]+)", [this](const auto& request, auto& response) {
        contents.take(request.matches[1], request.body);
        response.set_content("taken", "text/plain");
      });
    const bool bound = wanted == 0 ? (port = http.bind_to_any_port("127.0.0.1")) > 0
                                   : http.bind_to_port("127.0.0.1", wanted);
    if (!bound)
      throw std::runtime_error(fmt::format(
          "--page {}: this port cannot be had (another program's?); name another, or 0 for any",
          wanted));
    if (wanted != 0) port = wanted;
    thread = std::thread([this] { http.listen_after_bind(); });
    while (!http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  ~Impl() {
    broadcast.close();
    http.stop();
    thread.join();
  }

  bool own_name(const std::string& name) const {
    for (const char* host : {"127.0.0.1", "localhost", "[::1]"})
      if (name == fmt::format("{}:{}", host, port)) return true;
    return false;
  }

  /// Why this request is not served; empty when it is.
  std::string refused(const httplib::Request& request) const {
    if (!own_name(request.get_header_value("Host")))
      return "refused: not asked for under this machine's own name";
    const std::string origin = request.get_header_value("Origin");
    constexpr std::string_view kScheme = "http://";
    if (request.has_header("Origin") &&
        (!origin.starts_with(kScheme) || !own_name(origin.substr(kScheme.size()))))
      return "refused: asked by a page of another origin";
    const std::string site = request.get_header_value("Sec-Fetch-Site");
    if (site == "cross-site" && request.path != "/") return "refused: asked by another site";
    if (!same(request.get_param_value("token"), token))
      return "refused: the token is missing or wrong; use the address that sanso printed";
    return {};
  }

  void add_pages() {
    http.Get("/", [this](const auto&, auto& response) {
      if (!contents.page.empty())
        return response.set_content(contents.page, "text/html; charset=utf-8");
      const Bundle& built = bundle();
      if (built.empty()) return response.set_content(kNoBundle, "text/plain");
      response.set_header("Content-Encoding", "gzip");
      // through a provider: what set_content is given would be compressed once more
      const auto* bytes = reinterpret_cast<const char*>(built.page.data());
      response.set_content_provider(
          built.page.size(), "text/html; charset=utf-8",
          [bytes](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
            return sink.write(bytes + offset, length);
          });
    });
    http.Get("/scene.json", [this](const auto&, auto& response) {
      response.set_content(contents.scene(), "application/json");
    });
  }

  void add_events() {
    http.Get("/events", [this](const auto&, auto& response) {
      if (broadcast.viewers() >= kMostViewers) {
        response.status = kBusy;
        return response.set_content("too many viewers; close another page\n", "text/plain");
      }
      const std::shared_ptr<Broadcast::Viewer> viewer = broadcast.join(contents.greeting());
      response.set_chunked_content_provider("text/event-stream",
                                            [this, viewer](std::size_t, httplib::DataSink& sink) {
                                              std::string text = viewer->next(kKeepAlive);
                                              if (broadcast.closed()) return false;
                                              if (text.empty()) text = ": still here\n\n";
                                              return sink.write(text.data(), text.size());
                                            });
    });
  }

  void add_control() {
    http.Post("/control", [this](const auto& request, auto& response) {
      if (!contents.control) {
        response.status = kForbidden;
        return response.set_content("this page is for looking; start sanso with --control\n",
                                    "text/plain");
      }
      try {
        response.set_content(contents.control(request.body), "text/plain");
      } catch (const std::exception& error) {
        response.status = kRefused;
        response.set_content(std::string("refused: ") + error.what(), "text/plain");
      }
    });
  }

  ServerContents contents;
  std::string token;
  int port = 0;
  Broadcast broadcast;
  httplib::Server http;
  std::thread thread;
};

Server::Server(int port, ServerContents contents)
    : impl_(std::make_unique<Impl>(port, std::move(contents))) {}
Server::~Server() = default;
std::string Server::address() const {
  return fmt::format("http://127.0.0.1:{}/?token={}", impl_->port, impl_->token);
}
int Server::port() const { return impl_->port; }
Broadcast& Server::broadcast() { return impl_->broadcast; }

}  // namespace sanso::page
