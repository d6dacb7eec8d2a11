// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/server.h"

#include <libwebsockets.h>

#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/view/access.h"
#include "lucarium/view/hub.h"
#include "lucarium/view/page_files.h"

namespace lucarium {

namespace {

constexpr int open_files = 128;
constexpr unsigned request_timeout = 10;                // [s]
constexpr int64_t tick = int64_t{100} * LWS_US_PER_MS;  // [µs] between looks at `ended`
constexpr lws_retry_bo keep_alive = {.secs_since_valid_ping = 20, .secs_since_valid_hangup = 50};
constexpr const char* security_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'";

/// What a connection keeps: libwebsockets gives each a zeroed one.
struct Connection {
  uint64_t page;           ///< 0: none
  std::string* message;    ///< whose parts come one by one
  const PageFile* answer;  ///< of a request
  bool too_long;
};

std::string header(lws* wsi, lws_token_indexes token) {
  const int length = lws_hdr_total_length(wsi, token);
  if (length <= 0 || length > 2000) return {};
  std::string text(static_cast<size_t>(length) + 1, '\0');
  const int copied = lws_hdr_copy(wsi, text.data(), length + 1, token);
  text.resize(copied > 0 ? static_cast<size_t>(copied) : 0);
  return text;
}

}  // namespace

struct ViewServer::State {
  ViewHub& hub;
  std::string token = make_view_token(), url;
  int port = 0;
  lws_context* context = nullptr;
  lws_sorted_usec_list_t timer{};
  std::vector<unsigned char> buffer;
  std::array<lws_protocols, 3> protocols{};

  explicit State(ViewHub& h) : hub(h) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  /// Here, so that a server that cannot listen leaves nothing behind.
  ~State() {
    if (context) lws_context_destroy(context);
  }
  static State& of(lws* wsi) { return *static_cast<State*>(lws_context_user(lws_get_context(wsi))); }

  /// The part of "/TOKEN/NAME" behind the token; nullopt where the token is missing or the host is a stranger's.
  std::optional<std::string> allowed_path(lws* wsi, const std::string& path) const {
    const size_t end = path.find('/', 1);
    if (path.empty() || path[0] != '/' || end == std::string::npos) return std::nullopt;
    if (!same_token(std::string_view(path).substr(1, end - 1), token)) return std::nullopt;
    if (!is_host_allowed(header(wsi, WSI_TOKEN_HOST))) return std::nullopt;
    return path.substr(end + 1);
  }

  int refuse(lws* wsi, unsigned status) const {
    if (lws_return_http_status(wsi, status, nullptr) != 0) return -1;
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
  }

  int begin_answer(lws* wsi, Connection* connection, const std::string& path) {
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    const std::optional<std::string> name = allowed_path(wsi, path);
    if (!name) return refuse(wsi, HTTP_STATUS_FORBIDDEN);
    const PageFile& file = view_page_file(*name);
    if (file.type.empty()) return refuse(wsi, HTTP_STATUS_NOT_FOUND);
    std::array<unsigned char, LWS_PRE + 2048> space{};
    unsigned char *const start = space.data() + LWS_PRE, *at = start, *const end = space.data() + space.size() - 1;
    const auto add = [&](const char* key, const char* value) {
      return lws_add_http_header_by_name(wsi, reinterpret_cast<const unsigned char*>(key),
                                         reinterpret_cast<const unsigned char*>(value),
                                         static_cast<int>(std::strlen(value)), &at, end) == 0;
    };
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, file.type.c_str(), file.text.size(), &at, end) != 0 ||
        !add("content-security-policy:", security_policy) || !add("x-content-type-options:", "nosniff") ||
        !add("referrer-policy:", "no-referrer") || !add("cache-control:", "no-store") ||
        !add("cross-origin-resource-policy:", "same-origin") ||
        lws_finalize_write_http_header(wsi, start, &at, end) != 0)
      return -1;
    connection->answer = &file;
    lws_callback_on_writable(wsi);
    return 0;
  }

  int write(lws* wsi, std::string_view data, lws_write_protocol kind) {
    buffer.resize(LWS_PRE + data.size());
    std::memcpy(buffer.data() + LWS_PRE, data.data(), data.size());
    return lws_write(wsi, buffer.data() + LWS_PRE, data.size(), kind);
  }

  int finish_answer(lws* wsi, Connection* connection) {
    if (!connection->answer) return 0;
    const std::string& text = connection->answer->text;
    connection->answer = nullptr;
    if (write(wsi, text, LWS_WRITE_HTTP_FINAL) < 0) return -1;
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
  }

  int receive(lws* wsi, Connection* connection, std::string_view part) {
    std::string& message = *connection->message;
    if (lws_is_first_fragment(wsi) != 0) {
      message.clear();
      connection->too_long = false;
    }
    if (message.size() + part.size() > largest_view_message) {
      connection->too_long = true;
    } else {
      message += part;
    }
    if (lws_is_final_fragment(wsi) == 0 || lws_remaining_packet_payload(wsi) > 0) return 0;
    if (connection->too_long)
      hub.refuse(connection->page, "the message is too long");
    else if (lws_frame_is_binary(wsi) != 0)
      hub.refuse(connection->page, "a message is a JSON object");
    else
      hub.receive(connection->page, message);
    message.clear();
    return 0;
  }

  int send_next(lws* wsi, const Connection* connection) {
    const std::optional<ViewHub::Outgoing> next = hub.next(connection->page);
    if (!next) return 0;
    if (write(wsi, *next->data, next->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT) < 0) return -1;
    lws_callback_on_writable(wsi);
    return 0;
  }

  int join(lws* wsi, Connection* connection) {
    const std::optional<uint64_t> page = hub.join();
    if (!page) {
      lws_close_reason(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, nullptr, 0);
      return -1;
    }
    connection->page = *page;
    connection->message = new std::string;
    lws_callback_on_writable(wsi);
    return 0;
  }

  void leave(Connection* connection) {
    if (!connection || connection->page == 0) return;
    hub.leave(connection->page);
    connection->page = 0;
    delete connection->message;
    connection->message = nullptr;
  }

  static int on_http(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length) {
    auto* const connection = static_cast<Connection*>(user);
    switch (reason) {
      case LWS_CALLBACK_HTTP:
        return of(wsi).begin_answer(wsi, connection, std::string(static_cast<const char*>(in), length));
      case LWS_CALLBACK_HTTP_WRITEABLE: return of(wsi).finish_answer(wsi, connection);
      // Whoever wants a WebSocket of no protocol, or another one, is no page of ours.
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return 1;
      default: return lws_callback_http_dummy(wsi, reason, user, in, length);
    }
  }

  static int on_page(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length) {
    auto* const connection = static_cast<Connection*>(user);
    State* const state = wsi ? &of(wsi) : nullptr;
    switch (reason) {
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: {
        const std::optional<std::string> name = state->allowed_path(wsi, header(wsi, WSI_TOKEN_GET_URI));
        const std::string origin = header(wsi, WSI_TOKEN_ORIGIN);
        const bool ours = name == "socket" && is_origin_allowed(origin, header(wsi, WSI_TOKEN_HOST));
        return ours ? 0 : 1;
      }
      case LWS_CALLBACK_ESTABLISHED: return state->join(wsi, connection);
      case LWS_CALLBACK_RECEIVE: return state->receive(wsi, connection, {static_cast<const char*>(in), length});
      case LWS_CALLBACK_SERVER_WRITEABLE: return state->send_next(wsi, connection);
      case LWS_CALLBACK_CLOSED: state->leave(connection); return 0;
      case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        lws_callback_on_writable_all_protocol(lws_get_context(wsi), lws_get_protocol(wsi));
        return 0;
      default: return 0;
    }
  }

  static void on_tick(lws_sorted_usec_list_t*) {}  // that service() returns is enough
};

std::string view_server_obstacle() { return {}; }

ViewServer::ViewServer(ViewHub& hub, const ViewServerOptions& options) : state_(std::make_unique<State>(hub)) {
  State& state = *state_;
  if (!options.token.empty()) state.token = options.token;
  lws_set_log_level(0, nullptr);
  state.protocols = {
      lws_protocols{.name = "http", .callback = State::on_http, .per_session_data_size = sizeof(Connection)},
      lws_protocols{.name = "lucarium-view",
                    .callback = State::on_page,
                    .per_session_data_size = sizeof(Connection),
                    .rx_buffer_size = largest_view_message},
      lws_protocols{}};
  lws_context_creation_info info{};
  info.iface = options.address.c_str();
  info.port = options.port;
  info.protocols = state.protocols.data();
  info.user = &state;
  info.gid = static_cast<gid_t>(-1);
  info.uid = static_cast<uid_t>(-1);
  info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  info.fd_limit_per_thread = open_files;
  info.timeout_secs = request_timeout;
  info.keepalive_timeout = request_timeout;
  info.retry_and_idle_policy = &keep_alive;
  state.context = lws_create_context(&info);
  if (!state.context) throw_error(ErrorClass::internal, "libwebsockets cannot be initialized");
  lws_vhost* const host = lws_create_vhost(state.context, &info);
  if (!host)
    throw_error(ErrorClass::usage, "cannot listen at {} port {}: give another --port or --listen", options.address,
                options.port);
  const bool is_ipv6 = options.address.find(':') != std::string::npos;
  state.port = lws_get_vhost_listen_port(host);
  state.url =
      fmt::format("http://{}:{}/{}/", is_ipv6 ? "[" + options.address + "]" : options.address, state.port, state.token);
  hub.on_news([context = state.context] { lws_cancel_service(context); });
}

ViewServer::~ViewServer() { state_->hub.on_news({}); }

const std::string& ViewServer::url() const { return state_->url; }
int ViewServer::port() const { return state_->port; }
const std::string& ViewServer::token() const { return state_->token; }

void ViewServer::run(const std::function<bool()>& ended) {
  while (!ended()) {
    lws_sul_schedule(state_->context, 0, &state_->timer, State::on_tick, tick);
    if (lws_service(state_->context, 0) < 0) throw_error(ErrorClass::internal, "the server of the viewer ended");
  }
  lws_sul_schedule(state_->context, 0, &state_->timer, State::on_tick, LWS_SET_TIMER_USEC_CANCEL);
}

}  // namespace lucarium
