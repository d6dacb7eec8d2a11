// SPDX-License-Identifier: Apache-2.0
// In builds without libwebsockets: no server. Declared in server.h.
#include "lucarium/base/error.h"
#include "lucarium/view/server.h"

namespace lucarium {

struct ViewServer::State {};

std::string view_server_obstacle() {
  return "this build has no viewer: install libwebsockets-dev, configure with LUCARIUM_VIEW=ON and build again";
}

ViewServer::ViewServer(ViewHub&, const ViewServerOptions&) {
  throw_error(ErrorClass::usage, "{}", view_server_obstacle());
}
ViewServer::~ViewServer() = default;

const std::string& ViewServer::url() const {
  static const std::string none;
  return none;
}

int ViewServer::port() const { return 0; }

const std::string& ViewServer::token() const { return url(); }

void ViewServer::run(const std::function<bool()>&) {}

}  // namespace lucarium
