// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

#include "lucarium/base/error.h"

namespace lucarium {

namespace {

/// The host without its port; empty where the header is not of the form HOST[:PORT].
std::string host_name(std::string_view host) {
  std::string_view name = host, port;
  if (host.starts_with('[')) {
    const size_t end = host.find(']');
    if (end == std::string_view::npos) return {};
    name = host.substr(1, end - 1);
    port = host.substr(end + 1);
  } else if (const size_t colon = host.find(':'); colon != std::string_view::npos) {
    name = host.substr(0, colon);
    port = host.substr(colon);
  }
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!port.empty() && (port[0] != ':' || !std::all_of(port.begin() + 1, port.end(), is_digit))) return {};
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

bool is_address(const std::string& name) {
  std::array<uint8_t, 16> bytes{};
  return ::inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
}

}  // namespace

std::string make_view_token() {
  std::array<uint8_t, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw_error(ErrorClass::internal, "the system has no random numbers for the address of the page");
  std::string token;
  for (const uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_token(std::string_view given, std::string_view token) {
  if (given.size() != token.size()) return false;
  int different = 0;
  for (size_t i = 0; i < token.size(); ++i) different |= given[i] ^ token[i];
  return different == 0;
}

bool is_host_allowed(std::string_view host) {
  const std::string name = host_name(host);
  if (name.empty()) return false;
  std::array<char, 256> own{};
  const bool has_name = ::gethostname(own.data(), own.size() - 1) == 0;
  return name == "localhost" || is_address(name) || (has_name && name == host_name(own.data()));
}

bool is_origin_allowed(std::string_view origin, std::string_view host) {
  constexpr std::string_view scheme = "http://";
  return origin.starts_with(scheme) && !host.empty() && origin.substr(scheme.size()) == host;
}

bool is_loopback(std::string_view address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

}  // namespace lucarium
