// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

namespace lucarium {

class ViewHub;

struct ViewServerOptions {
  std::string address = "127.0.0.1";  ///< to listen at
  int port = 0;                       ///< 0: a free one
  std::string token;                  ///< empty: a new one
};

/// Why there is no server in this build, for people; empty: there is one.
std::string view_server_obstacle();

/// Serves the viewer's page and its WebSocket, on the thread that calls run(). Requests without the token of the
/// address, under a stranger's Host, or from another Origin are refused; no file is read. A page that takes no data
/// holds up nobody: what cannot be sent waits for its own socket alone.
class ViewServer {
 public:
  /// Listens from now on. Throws Error{usage} for an address or a port that cannot be had.
  ViewServer(ViewHub& hub, const ViewServerOptions& options);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Where the page is: http://127.0.0.1:PORT/TOKEN/
  const std::string& url() const;
  int port() const;
  const std::string& token() const;
  /// Until `ended`, which is asked about ten times a second.
  void run(const std::function<bool()>& ended);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
