// SPDX-License-Identifier: Apache-2.0
// Who may talk to the viewer.
#pragma once
#include <string>
#include <string_view>

namespace lucarium {

/// 128 random bits as 32 hexadecimal digits, from the system's generator.
std::string make_view_token();

/// In a time that does not depend on where they differ.
bool same_token(std::string_view given, std::string_view token);

/// Whether a page under this Host header ("localhost:8080", "[::1]:80") can be ours: the host is an address, localhost,
/// or the name of this machine. A stranger's name that was made to point here (DNS rebinding) is not.
bool is_host_allowed(std::string_view host);

/// Whether a WebSocket was opened by the page itself: its Origin is http:// and the Host that it was sent to.
bool is_origin_allowed(std::string_view origin, std::string_view host);

/// Whether only this machine reaches that address: 127.0.0.1, ::1, localhost.
bool is_loopback(std::string_view address);

}  // namespace lucarium
