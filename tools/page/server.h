// The page over HTTP on loopback: the page itself, the scene, a stream of server-sent events, and
// one door for what a person asks. Nobody gets in without the token that is in the address, under
// another name than this machine's own, or from another page.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/page/broadcast.h"

namespace sanso::page {

struct ServerContents {
  std::function<std::string()> scene;                  // JSON
  std::function<std::vector<std::string>()> greeting;  // events that a new viewer gets first
  /// What a person asks, as JSON, to the words of the answer; throws std::runtime_error to refuse.
  /// Absent: the page is for looking only.
  std::function<std::string(const std::string&)> control;
  /// In place of the live page, for a browser of ours that draws it: what the page makes comes back
  /// by name.
  std::string page = {};
  std::function<void(const std::string& name, std::string body)> take = {};
};

class Server {
 public:
  /// Serves at once, in threads of its own. `port` 0: any free one. Throws std::runtime_error when
  /// the port cannot be had.
  Server(int port, ServerContents contents);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// With the token: whoever has it may look.
  std::string address() const;
  int port() const;
  Broadcast& broadcast();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One server-sent event.
std::string event(const std::string& name, const std::string& data);

}  // namespace sanso::page
